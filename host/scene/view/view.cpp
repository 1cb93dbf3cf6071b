// SPDX-License-Identifier: Apache-2.0
// Cameras, and the bounds that they frame. Every length scales with the scene, so that a scene
// times 2^k gives the same picture.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/emission.h"
#include "scene/endless.h"
#include "scene/view/framing.h"
#include "scene/limits.h"
#include "scene/scene.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr double kFramingFovRad = 40.0 * 3.14159265358979323846 / 180.0;
constexpr double kFramedShare = 0.92;          // of the picture's width or height, whichever is filled
const glm::dvec3 kFramingSide(0.5, 0.4, 0.9);  // where the camera stands: glTF's front is +Z

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

namespace {

/// Calls `visit` with the world position of each vertex of the nodes' meshes that shows, and with
/// the corners of the box of each shape.
template <class Visit>
void for_each_vertex(const Scene& scene, const Visit& visit) {
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      for (const glm::vec3& position : primitive.positions_object)
        visit(transform_point(node.world_from_object, position), primitive.material);
  for (const Shape& shape : scene.shapes) {
    const OwnShape own = own_shape(bounded_piece(shape));
    for (int k = 0; k < 8; ++k) {
      const glm::dvec3 corner((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
      visit(own.center + corner * own.half, shape.material);
    }
  }
}

/// True if the whole material is cut away, or lets all light through without a trace.
bool never_shows(const Material& material) {
  if (material.alpha_mode == AlphaMode::opaque) return false;
  return material.alpha_mode == AlphaMode::mask ? material.opacity < material.alpha_cutoff : material.opacity == 0;
}

}  // namespace

Bounds world_bounds(const Scene& scene) {
  Bounds bounds;
  for_each_vertex(scene, [&](const glm::dvec3& p, std::uint32_t) {
    bounds.lo = glm::min(bounds.lo, p);
    bounds.hi = glm::max(bounds.hi, p);
  });
  return bounds;
}

double lens_radius_m(const Camera& camera) {
  if (!camera.lens || camera.projection != Projection::perspective) return 0;
  if (camera.lens->radius_m > 0) return camera.lens->radius_m;
  const double focal_length_m = 0.5 * camera.lens->sensor_height_m / std::tan(0.5 * camera.yfov_rad);
  return 0.5 * focal_length_m / camera.lens->f_number;
}

double half_height_m(const Camera& camera) {
  return camera.projection == Projection::orthographic ? camera.ymag_m : std::tan(0.5 * camera.yfov_rad);
}

bool same_view(const Camera& a, const Camera& b) {
  const auto focus = [](const Camera& camera) { return camera.lens ? camera.lens->focus_distance_m : 0; };
  return a.world_from_camera == b.world_from_camera && a.projection == b.projection && a.yfov_rad == b.yfov_rad &&
         a.ymag_m == b.ymag_m && lens_radius_m(a) == lens_radius_m(b) && focus(a) == focus(b);
}

Framing::Framing(double aspect) : aspect_(aspect > 0 ? aspect : 0.0) {
  const double tangent = std::tan(0.5 * kFramingFovRad) * kFramedShare;
  across_.tangent = tangent * (aspect > 0 ? aspect : 1.0);
  along_.tangent = tangent;
  back_ = glm::normalize(kFramingSide);
  right_ = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back_));
  up_ = glm::cross(back_, right_);
}

void Framing::add(const Scene& scene) {
  const Bounds bounds = world_bounds(scene);
  if (!center_) center_ = bounds.empty() ? glm::dvec3{0.0} : (bounds.lo + bounds.hi) * 0.5;
  bounds_.lo = glm::min(bounds_.lo, bounds.lo);
  bounds_.hi = glm::max(bounds_.hi, bounds.hi);
  for_each_vertex(scene, [&](const glm::dvec3& p, std::uint32_t material) {
    if (never_shows(scene.materials[material])) return;
    add_point(p);
    shows_ = true;
  });
}

void Framing::add_point(const glm::dvec3& p) {
  const glm::dvec3 offset = p - *center_;
  across_.add(glm::dot(offset, right_), glm::dot(offset, back_));
  along_.add(glm::dot(offset, up_), glm::dot(offset, back_));
}

Camera Framing::camera() const {
  Framing all = *this;
  if (!all.center_) all.center_ = glm::dvec3(0.0);
  if (!shows_ || bounds_.lo == bounds_.hi)  // nothing, or a single point
    for (const double corner : {-1.0, 1.0}) all.add_point(*all.center_ + glm::dvec3(corner));
  const Fit &across = all.across_, &along = all.along_;
  const glm::dvec3 eye =
      *all.center_ + right_ * across.side() + up_ * along.side() + back_ * std::max(across.back(), along.back());
  return {.name = "framing",
          .world_from_camera = pose(eye, back_, right_),
          .yfov_rad = kFramingFovRad,
          .aspect = aspect_};
}

Camera frame_camera(const Scene& scene, double aspect) {
  Framing framing(aspect);
  framing.add(scene);
  return framing.camera();
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
