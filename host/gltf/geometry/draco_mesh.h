// SPDX-License-Identifier: Apache-2.0
// KHR_draco_mesh_compression: primitives whose triangles are a Draco stream.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/document/document.h"

namespace eikon {

/// A decoded stream: its triangles, and the attributes that stand in for those of the file.
struct DracoMesh {
  std::vector<std::uint32_t> indices;          // three per triangle, each below the number of positions
  std::map<std::string, Accessor> attributes;  // by glTF's names; read from `storage`
  std::vector<Bytes> storage;
};

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

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

 private:
  const BufferViews& views_;
  const AccessorTable& accessors_;
  std::uint64_t triangles_claimed_ = 0, bytes_seen_ = 0;
};

}  // namespace eikon
