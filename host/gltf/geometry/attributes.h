// SPDX-License-Identifier: Apache-2.0
// The attributes of a mesh: the types that glTF allows for each, and what becomes of values that it
// does not allow.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "scene/limits.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// The largest texture coordinate; beyond it single precision has no fraction left.
inline constexpr float kMaxTextureCoordinate = 16777216.0F;  // 2^24

/// The vertices of an attribute that a primitive keeps: all in order, or those listed.
struct VertexChoice {
  const std::vector<std::uint32_t>& used;  // empty: all
  std::size_t count = 0;
  [[nodiscard]] std::uint64_t operator[](std::size_t i) const { return used.empty() ? i : used[i]; }
};

/// Checks type and size of attribute `name` ("POSITION", "TEXCOORD_0", ...) of `user`; `quantized`
/// allows the types of KHR_mesh_quantization. throws InputError
void check_attribute(const std::string& name, const Accessor& accessor, std::uint64_t position_count, bool quantized,
                     const std::string& user);

/// throws InputError naming the first position that is not finite or beyond kMaxCoordinate
void check_positions(const Accessor& positions);

// The readers take accessors that check_attribute has let pass. One warning names what they change
// or drop, with the first element concerned and the number of them.

std::vector<glm::vec3> read_positions(const Accessor& positions, const VertexChoice& vertices);

/// Returns unit vectors. One that is zero or not finite in the file becomes that of its triangles;
/// nothing is returned if all are. `primitive`: its positions and indices are read
std::vector<glm::vec3> read_normals(const Accessor& normals, const VertexChoice& vertices, const Primitive& primitive,
                                    const std::string& user, Notes& notes);

/// Returns finite coordinates up to kMaxTextureCoordinate; (0, 0) instead of others.
std::vector<glm::vec2> read_texture_coordinates(const Accessor& uv, const VertexChoice& vertices,
                                                const std::string& user, Notes& notes);

/// Returns colours in [0, 1], opaque if the file has no alpha, white instead of NaN; nothing if all
/// are white and opaque.
std::vector<glm::vec4> read_colors(const Accessor& colors, const VertexChoice& vertices, const std::string& user,
                                   Notes& notes);

/// Returns unit tangents with w = 1 or -1, or nothing if one has no direction or is parallel to its
/// normal. `normals`: one per vertex, unit.
std::vector<glm::vec4> read_tangents(const Accessor& tangents, const VertexChoice& vertices,
                                     const std::vector<glm::vec3>& normals, const std::string& user, Notes& notes);

}  // namespace eikon
