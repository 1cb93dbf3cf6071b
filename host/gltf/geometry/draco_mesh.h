// SPDX-License-Identifier: Apache-2.0
// KHR_draco_mesh_compression: primitives whose triangles are a Draco stream.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/document/document.h"
#include "scene/scene.h"

namespace eikon {

/// A decoded stream: its triangles, and the attributes that stand in for those of the file.
struct DracoMesh {
  std::vector<std::uint32_t> indices;          // three per triangle, each below the number of positions
  std::map<std::string, Accessor> attributes;  // by glTF's names; read from `storage`
  std::vector<Bytes> storage;
};

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// The most memory that the library has at a time for a stream of these counts, with what it
/// unpacks: for each triangle its corners, their opposites and their vertices (12, 12 and 12 bytes,
/// the last for each attribute too, as it may have seams of its own) and 8 bytes of order, and for
/// each vertex its numbers twice, as integers and as they are in the end.
/// numbers  of a vertex, of all attributes together
[[nodiscard]] double draco_decoder_bytes(std::uint64_t triangles, std::uint64_t vertices, std::size_t attributes,
                                         std::uint64_t numbers);

/// Decodes Draco streams and counts what they claim. Honest files hold each stream once, so all of
/// them together may claim no more triangles than their bytes can hold.
class DracoDecoder {
 public:
  /// The arguments outlive the decoder.
  DracoDecoder(const BufferViews& views, const AccessorTable& accessors) : views_(views), accessors_(accessors) {}

  /// `view` is the extension in `primitive`.
  /// throws InputError with the place: members that do not fit, a stream that claims other counts
  ///        or types than the accessors, or more than its bytes can hold, or that does not decode
  DracoMesh decode(const JsonView& view, const GltfPrimitive& primitive);

  /// The memory for decode(), by what the accessors announce and what so many bytes can hold; 0 if
  /// the extension names no stream.
  [[nodiscard]] double expected_bytes(const Json& extension, const GltfPrimitive& primitive) const;
  /// The sizes of the streams that were decoded so far.
  [[nodiscard]] const CompressedMeshes& decoded() const { return decoded_; }

 private:
  const BufferViews& views_;
  const AccessorTable& accessors_;
  std::uint64_t triangles_claimed_ = 0;
  CompressedMeshes decoded_;
};

}  // namespace eikon
