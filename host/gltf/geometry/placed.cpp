// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/placed.h"

#include "formula/host_lanes.h"

namespace eikon::host_lanes {
// By path: a plain "math.h" would be the system's.
#include "surface/instance.h"
}  // namespace eikon::host_lanes

namespace eikon {
namespace {

host_lanes::v3 lanes(const glm::vec3& a) { return {a.x, a.y, a.z}; }
glm::vec3 vector(const host_lanes::v3& a) { return {a.x, a.y, a.z}; }
host_lanes::Placing lanes(const PlacingMatrix& m) {
  return {lanes(m.rows[0]), lanes(m.rows[1]), lanes(m.rows[2]), lanes(m.translation)};
}

}  // namespace

PlacingMatrix placing_matrix(const glm::dmat4& m) {
  PlacingMatrix placing;
  for (int i = 0; i < 3; ++i) placing.rows[std::size_t(i)] = glm::vec3(float(m[0][i]), float(m[1][i]), float(m[2][i]));
  placing.translation = glm::vec3(m[3]);
  return placing;
}

glm::dmat3 linear_part(const PlacingMatrix& m) {
  return glm::transpose(glm::dmat3(glm::dvec3(m.rows[0]), glm::dvec3(m.rows[1]), glm::dvec3(m.rows[2])));
}

glm::vec3 placed_point(const PlacingMatrix& m, const glm::vec3& p) {
  return vector(host_lanes::placed_point(lanes(m), lanes(p)));
}
glm::vec3 placed_normal(const PlacingMatrix& m, bool mirrored, const glm::vec3& n) {
  return vector(host_lanes::placed_normal(lanes(m), mirrored ? -1.0F : 1.0F, lanes(n)));
}
glm::vec3 placed_tangent(const PlacingMatrix& m, const glm::vec3& t) {
  return vector(host_lanes::unit_or_zero(host_lanes::placed_direction(lanes(m), lanes(t))));
}
glm::vec3 placed_triangle_normal(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
  return vector(host_lanes::placed_triangle_normal(lanes(p0), lanes(p1), lanes(p2)));
}

}  // namespace eikon
