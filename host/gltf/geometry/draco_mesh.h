// SPDX-License-Identifier: Apache-2.0
// KHR_draco_mesh_compression: primitives whose triangles are a Draco stream.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"

namespace eikon {

/// A decoded stream: its triangles, and the attributes that stand in for those of the file.
struct DracoMesh {
  std::vector<std::uint32_t> indices;          // three per triangle, each below the number of positions
  std::map<std::string, Accessor> attributes;  // by glTF's names; read from `storage`
  std::vector<Bytes> storage;
};

/// The extension's object in a primitive; null if it has none.
[[nodiscard]] const Json* draco_member(const Json& primitive);

/// Decodes Draco streams, and keeps account: honest files hold each stream once, so all of them together may claim no
/// more triangles than their bytes can hold.
class DracoDecoder {
 public:
  /// The arguments outlive the decoder.
  DracoDecoder(const BufferViews& views, const std::vector<Accessor>& accessors)
      : views_(views), accessors_(accessors) {}

  /// `primitive`: the object around the extension, already checked; `place`: the extension.
  /// throws InputError with the place: members that do not fit, a stream that claims other counts or types than the
  /// accessors, or more than its bytes can hold, or that does not decode
  DracoMesh decode(const Place& place, const Json& primitive);

 private:
  const BufferViews& views_;
  const std::vector<Accessor>& accessors_;
  std::uint64_t triangles_claimed_ = 0, bytes_seen_ = 0;
};

}  // namespace eikon
