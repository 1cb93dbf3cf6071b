// SPDX-License-Identifier: Apache-2.0
// Makes triangles of the corners of a primitive.
#pragma once
#include <cstdint>
#include <string>

#include "gltf/document/accessor_table.h"
#include "scene/triangle_indices.h"

namespace eikon {

/// throws InputError naming `user`: indices that are not plain unsigned integers, one that is not
/// below `vertex_count` or is the primitive restart value
void check_indices(const Accessor& indices, std::uint64_t vertex_count, const std::string& user);

/// The triangles of checked indices; null: of all vertices in their order.
[[nodiscard]] TriangleIndices read_triangles(const Accessor* indices, TriangleMode mode, std::uint64_t vertex_count);

}  // namespace eikon
