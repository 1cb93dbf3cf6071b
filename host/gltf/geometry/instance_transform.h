// SPDX-License-Identifier: Apache-2.0
// An instance of a mesh by the operations of kernels/surface/instance.h: the bits that devices get
// where the mesh is stored once.
#pragma once
#include <array>
#include <glm/glm.hpp>

namespace eikon {

/// A matrix in floats: rows of world = m (x, y, z) + t.
struct InstanceTransform {
  std::array<glm::vec3, 3> rows{};
  glm::vec3 translation{0.0F};
};

/// m in doubles, as GLM has matrices.
[[nodiscard]] glm::dmat3 linear_part(const InstanceTransform& m);
[[nodiscard]] InstanceTransform instance_transform(const glm::dmat4& world_from_object);
[[nodiscard]] glm::vec3 instance_point(const InstanceTransform& m, const glm::vec3& p);
/// Takes unit or zero vectors and returns such vectors. mirrored: the determinant is negative, and
/// normals turn
[[nodiscard]] glm::vec3 instance_normal(const InstanceTransform& m, bool mirrored, const glm::vec3& n);
[[nodiscard]] glm::vec3 instance_tangent(const InstanceTransform& m, const glm::vec3& t);
/// The unit normal of corners in the world; zero where they have no area.
[[nodiscard]] glm::vec3 accurate_triangle_normal(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2);

}  // namespace eikon
