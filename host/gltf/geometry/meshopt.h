// SPDX-License-Identifier: Apache-2.0
// EXT_meshopt_compression and KHR_meshopt_compression: bufferViews that hold vertices or indices in
// the codecs of meshoptimizer. Both have the same members; the second also allows streams and
// filters that came later, which are refused by name.
#pragma once
#include <optional>

#include "gltf/document/buffer_views.h"

namespace eikon {

/// The most bytes that come out of one: the codecs spend at least two bits on 16 bytes of vertices,
/// a byte on a triangle, and a byte on an index.
inline constexpr std::uint64_t kMeshoptExpansion = 64;

/// The checked extension of a bufferView. Decoding it writes exactly `decoded_bytes`.
struct MeshoptView {
  enum class Mode { attributes, triangles, indices };
  enum class Filter { none, octahedral, quaternion, exponential };
  std::span<const std::byte> compressed;
  std::uint64_t count = 0;
  std::uint32_t stride_bytes = 0;
  Mode mode = Mode::attributes;
  Filter filter = Filter::none;
  [[nodiscard]] std::uint64_t decoded_bytes() const { return count * stride_bytes; }
};

/// The extension of a bufferView, if it is compressed.
std::optional<JsonView> find_meshopt(const JsonView& buffer_view);

/// throws InputError with the place: values that the extension does not allow, bytes outside their
///        buffer, more elements than the codec can put into so few bytes
MeshoptView check_meshopt(const JsonView& extension, const Buffers& buffers);

/// throws InputError with the place when the data are damaged or of a newer version of the codec
Bytes decode_meshopt(const JsonView& extension, const MeshoptView& view);

}  // namespace eikon
