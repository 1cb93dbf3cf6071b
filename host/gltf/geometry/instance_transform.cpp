// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/instance_transform.h"

#include "formula/host_lanes.h"

namespace eikon::host_lanes {
// By path: a plain "math.h" would be the system's.
#include "surface/instance.h"
}  // namespace eikon::host_lanes

namespace eikon {
namespace {

host_lanes::v3 lanes(const glm::vec3& a) { return {a.x, a.y, a.z}; }
glm::vec3 vector(const host_lanes::v3& a) { return {a.x, a.y, a.z}; }
host_lanes::InstanceTransform lanes(const InstanceTransform& m) {
  return {lanes(m.rows[0]), lanes(m.rows[1]), lanes(m.rows[2]), lanes(m.translation)};
}

}  // namespace

InstanceTransform instance_transform(const glm::dmat4& m) {
  InstanceTransform transform;
  for (int i = 0; i < 3; ++i)
    transform.rows[std::size_t(i)] = glm::vec3(float(m[0][i]), float(m[1][i]), float(m[2][i]));
  transform.translation = glm::vec3(m[3]);
  return transform;
}

glm::dmat3 linear_part(const InstanceTransform& m) {
  return glm::transpose(glm::dmat3(glm::dvec3(m.rows[0]), glm::dvec3(m.rows[1]), glm::dvec3(m.rows[2])));
}

glm::vec3 instance_point(const InstanceTransform& m, const glm::vec3& p) {
  return vector(host_lanes::instance_point(lanes(m), lanes(p)));
}
glm::vec3 instance_normal(const InstanceTransform& m, bool mirrored, const glm::vec3& n) {
  return vector(host_lanes::instance_normal(lanes(m), mirrored ? -1.0F : 1.0F, lanes(n)));
}
glm::vec3 instance_tangent(const InstanceTransform& m, const glm::vec3& t) {
  return vector(host_lanes::unit_or_zero(host_lanes::instance_direction(lanes(m), lanes(t))));
}
glm::vec3 accurate_triangle_normal(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
  return vector(host_lanes::accurate_triangle_normal(lanes(p0), lanes(p1), lanes(p2)));
}

}  // namespace eikon
