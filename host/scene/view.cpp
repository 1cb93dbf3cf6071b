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

/// Calls `visit` with the world position of each vertex of the nodes' meshes that shows, and with the
/// corners of the box of each shape.
template <class Visit>
void for_each_vertex(const Scene& scene, const Visit& visit) {
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      for (const glm::vec3& position : primitive.positions_object)
        visit(glm::dvec3(node.world_from_object * glm::dvec4(position, 1.0)), primitive.material);
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

/// The range of positions of a camera along one axis of its picture and along its axis of view.
/// [Every point p satisfies |p.side - at.side| <= tangent * (at.back - p.back) if and only if
/// `most` <= at.side + tangent * at.back and `least` <= tangent * at.back - at.side.]
struct Fit {
  double tangent;
  double most = -1e300, least = -1e300;
  void add(double side, double back) {
    most = std::max(most, side + tangent * back);
    least = std::max(least, tangent * back - side);
  }
  [[nodiscard]] double side() const { return 0.5 * (most - least); }
  [[nodiscard]] double back() const { return 0.5 * (most + least) / tangent; }
};

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

namespace {

/// Frames points within `bounds`. for_each_point: calls what it is given with each of them
template <class ForEachPoint>
Camera frame(const Bounds& bounds, double aspect, const ForEachPoint& for_each_point) {
  const glm::dvec3 center = bounds.empty() ? glm::dvec3{0.0} : (bounds.lo + bounds.hi) * 0.5;
  const glm::dvec3 back = glm::normalize(kFramingSide);
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back)), up = glm::cross(back, right);
  const double tangent = std::tan(0.5 * kFramingFovRad) * kFramedShare;
  Fit across{.tangent = tangent * (aspect > 0 ? aspect : 1.0)}, along{.tangent = tangent};
  bool shows = false;
  const auto add = [&](const glm::dvec3& p) {
    across.add(glm::dot(p - center, right), glm::dot(p - center, back));
    along.add(glm::dot(p - center, up), glm::dot(p - center, back));
    shows = true;
  };
  for_each_point(add);
  if (!shows || bounds.lo == bounds.hi)  // nothing, or a single point
    for (const double corner : {-1.0, 1.0}) add(center + glm::dvec3(corner));
  const glm::dvec3 eye =
      center + right * across.side() + up * along.side() + back * std::max(across.back(), along.back());
  return {.name = "framing",
          .world_from_camera = pose(eye, back, right),
          .yfov_rad = kFramingFovRad,
          .aspect = aspect > 0 ? aspect : 0.0};
}

}  // namespace

Camera frame_camera(const Scene& scene, double aspect) {
  return frame(world_bounds(scene), aspect, [&](const auto& add) {
    for_each_vertex(scene, [&](const glm::dvec3& p, std::uint32_t material) {
      if (!never_shows(scene.materials[material])) add(p);
    });
  });
}

Camera frame_boxes(const std::vector<Bounds>& boxes, double aspect) {
  Bounds all;
  for (const Bounds& box : boxes) {
    all.lo = glm::min(all.lo, box.lo);
    all.hi = glm::max(all.hi, box.hi);
  }
  return frame(all, aspect, [&](const auto& add) {
    for (const Bounds& box : boxes)
      for (int k = 0; k < 8; ++k)
        add(glm::dvec3((k & 1) != 0 ? box.lo.x : box.hi.x, (k & 2) != 0 ? box.lo.y : box.hi.y,
                       (k & 4) != 0 ? box.lo.z : box.hi.z));
  });
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
