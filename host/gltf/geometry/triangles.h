// SPDX-License-Identifier: Apache-2.0
// Makes triangles of the corners of a primitive.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"

namespace eikon {

/// The ways in which corners form triangles; the values are those of glTF's "mode".
enum class TriangleMode { list = 4, strip = 5, fan = 6 };

/// The indices of a primitive. throws InputError naming `user`: not plain unsigned integers, one
/// that is not below `vertex_count` or is the primitive restart value
std::vector<std::uint32_t> read_indices(const Accessor& indices, std::uint64_t vertex_count, const std::string& user);

/// Three corners per triangle, in the order of [glTF 2.0, section 3.7.2.1], by which every other
/// triangle of a strip turns. Triangles of strips and fans with a corner twice only lead on to the
/// next one and are dropped; those of lists stay. Corners beyond the last whole triangle are
/// dropped.
std::vector<std::uint32_t> list_triangles(std::vector<std::uint32_t> corners, TriangleMode mode);

}  // namespace eikon
