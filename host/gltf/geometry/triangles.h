// SPDX-License-Identifier: Apache-2.0
// Makes triangles of the corners of a primitive.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "scene/triangle_indices.h"

namespace eikon {

/// throws InputError naming `user`: indices that are not plain unsigned integers, one that is not
/// below `vertex_count` or is the primitive restart value
void check_indices(const Accessor& indices, std::uint64_t vertex_count, const std::string& user);

/// The triangles of checked indices; null: of all vertices in their order.
[[nodiscard]] TriangleIndices read_triangles(const Accessor* indices, TriangleMode mode, std::uint64_t vertex_count);

/// Leaves vertices out that no triangle uses.
class VertexCompactor {
 public:
  /// Renumbers `indices` to the vertices they use; returns those, or nothing when they use all of
  /// them.
  std::vector<std::uint32_t> renumber(TriangleIndices& indices, std::uint64_t vertex_count);

 private:
  static constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
  std::vector<std::uint32_t> slot_;  // by vertex; all kNoSlot between calls, as many primitives may share a large file
};

}  // namespace eikon
