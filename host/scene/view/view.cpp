// SPDX-License-Identifier: Apache-2.0
// Cameras, and the bounds that they frame. Every length scales with the scene, so that a scene
// times 2^k gives the same picture.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/emission.h"
#include "scene/endless.h"
#include "scene/limits.h"
#include "scene/scene.h"

namespace eikon {
namespace {

constexpr double kFramingFovRad = 40.0 * 3.14159265358979323846 / 180.0;
constexpr double kFramingElevation = 0.25;  // rise per metre of distance: "slightly above"

glm::dmat4 pose(const glm::dvec3& eye, const glm::dvec3& back_unit, const glm::dvec3& right_unit) {
  return {glm::dvec4(right_unit, 0.0), glm::dvec4(glm::cross(back_unit, right_unit), 0.0), glm::dvec4(back_unit, 0.0),
          glm::dvec4(eye, 1.0)};
}

}  // namespace

const Material* first_emitter(const Scene& scene) {
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      if (emits(scene.materials[primitive.material])) return &scene.materials[primitive.material];
  for (const Shape& shape : scene.shapes)
    if (emits(scene.materials[shape.material])) return &scene.materials[shape.material];
  return nullptr;
}

bool needs_environment(const Scene& scene) {
  if (first_emitter(scene) != nullptr) return false;
  for (const PunctualLight& light : scene.lights)
    if (light.intensity.x > 0 || light.intensity.y > 0 || light.intensity.z > 0) return false;
  bool shown = false;
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) {
      if (!scene.materials[primitive.material].unlit) return true;
      shown = true;
    }
  for (const Shape& shape : scene.shapes) {
    if (!scene.materials[shape.material].unlit) return true;
    shown = true;
  }
  return !shown;
}

Bounds world_bounds(const Scene& scene) {
  Bounds bounds;
  for (const Node& node : scene.nodes) {
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) {
      for (const glm::vec3& position : primitive.positions_object) {
        const glm::dvec3 p(node.world_from_object * glm::dvec4(position, 1.0));
        bounds.lo = glm::min(bounds.lo, p);
        bounds.hi = glm::max(bounds.hi, p);
      }
    }
  }
  for (const Shape& shape : scene.shapes) {
    const OwnShape own = own_shape(bounded_piece(shape));
    bounds.lo = glm::min(bounds.lo, own.center - own.half);
    bounds.hi = glm::max(bounds.hi, own.center + own.half);
  }
  return bounds;
}

double lens_radius_m(const Camera& camera) {
  if (!camera.lens || camera.projection != Projection::perspective) return 0;
  if (camera.lens->radius_m > 0) return camera.lens->radius_m;
  const double focal_length_m = 0.5 * camera.lens->sensor_height_m / std::tan(0.5 * camera.yfov_rad);
  return 0.5 * focal_length_m / camera.lens->f_number;
}

Camera frame_camera(const Bounds& bounds, double aspect) {
  const glm::dvec3 center = bounds.empty() ? glm::dvec3{0.0} : (bounds.lo + bounds.hi) * 0.5;
  double radius = bounds.empty() ? 0.0 : glm::length(bounds.hi - bounds.lo) * 0.5;
  if (!(radius > 0)) radius = 1;
  const double shape = aspect > 0 ? aspect : 1.0;
  // The bounding sphere touches the narrower of the two fields of view.
  const double half_y = 0.5 * kFramingFovRad, half_x = std::atan(std::tan(half_y) * shape);
  const double distance = radius / std::sin(std::min(half_x, half_y));
  const glm::dvec3 back = glm::normalize(glm::dvec3(0.0, kFramingElevation, 1.0));
  return {.name = "framing",
          .world_from_camera = pose(center + back * distance, back, glm::dvec3(1.0, 0.0, 0.0)),
          .yfov_rad = kFramingFovRad,
          .aspect = aspect > 0 ? aspect : 0.0};
}

Camera look_at_camera(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up, double yfov_rad) {
  for (const glm::dvec3& place : {eye, target, up})
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(place[axis]) <= kMaxCoordinate))
        throw UsageError("look-at: a coordinate is not within +-2^40 m, the largest; name a nearer one");
  if (!(yfov_rad > 0 && yfov_rad < 3.14159265358979)) {
    throw UsageError("look-at: the vertical field of view is not between 0 and 180 degrees");
  }
  const glm::dvec3 back = eye - target;
  const double distance = glm::length(back), up_length = glm::length(up);
  if (!(distance > 0)) throw UsageError("look-at: eye and target coincide; move one of them");
  if (!(up_length > 0)) throw UsageError("look-at: up has length 0; (0, 1, 0) is usual");
  const glm::dvec3 z = back / distance;
  const glm::dvec3 right = glm::cross(up / up_length, z);
  if (!(glm::length(right) > 1e-9))
    throw UsageError("look-at: up is parallel to the view; name another one, e.g. 0,0,1");
  return {.name = "look-at",
          .world_from_camera = pose(eye, z, right / glm::length(right)),
          .yfov_rad = yfov_rad,
          .aspect = 0.0};
}

}  // namespace eikon
