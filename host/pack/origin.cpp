// SPDX-License-Identifier: Apache-2.0
#include "pack/origin.h"

#include <cmath>
#include <memory>
#include <vector>

#include "pack/pack_parts.h"
#include "scene/endless.h"
#include "scene/shape.h"

namespace eikon {
namespace {

// A scene is far if its centre is so many times half its diagonal away. Nearer ones lose little,
// and keep the coordinates of their file.
constexpr double kFar = 32;

/// A box around all that has a place in the world. world_bounds() is tighter, but looks at each
/// vertex of each instance; this looks at each mesh once.
Bounds bounds_of(const Scene& scene) {
  Bounds bounds;
  std::vector<Bounds> of_mesh(scene.meshes.size());
  for (const Node& node : scene.nodes) {
    Bounds& own = of_mesh[node.mesh];
    if (own.empty())
      for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
        for (const glm::vec3& p : primitive.positions_object) grow(own, glm::dvec3(p));
    grow(bounds, node.world_from_object, own);
  }
  for (const Shape& shape : scene.shapes) {
    const OwnShape own = own_shape(is_endless(shape) ? bounded_piece(shape) : shape);
    grow(bounds, own.center - own.half);
    grow(bounds, own.center + own.half);
  }
  return bounds;
}

void move(Scene& scene, const glm::dvec3& by) {
  const glm::dvec4 way(by, 0);
  for (Node& node : scene.nodes) node.world_from_object[3] += way;
  for (Shape& shape : scene.shapes) shape.world_from_object[3] += way;
  for (PunctualLight& light : scene.lights) light.position += by;
  for (Camera& camera : scene.cameras) camera.world_from_camera[3] += way;
}

std::shared_ptr<const Scene> moved(const Scene& scene, const glm::dvec3& by) {
  auto copy = std::make_shared<Scene>(scene);
  move(*copy, by);
  return copy;
}

}  // namespace

glm::dvec3 origin_of(const Scene& scene, std::span<const glm::dvec3> more) {
  Bounds bounds = bounds_of(scene);
  for (const glm::dvec3& point : more) grow(bounds, point);
  if (bounds.empty()) return glm::dvec3(0);
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  const double radius = 0.5 * glm::length(bounds.hi - bounds.lo), away = glm::length(center);
  if (!(away > kFar * radius) || !std::isfinite(away)) return glm::dvec3(0);
  const double step = std::exp2(std::ceil(std::log2(std::max(radius, away * 0x1p-40))));
  return glm::round(center / step) * step;
}

Scene seen_from_origin(Scene scene, const glm::dvec3& origin) {
  move(scene, -origin);
  for (std::shared_ptr<const Scene>& pose : scene.poses) pose = moved(*pose, -origin);
  if (scene.next != nullptr) scene.next = moved(*scene.next, -origin);
  return scene;
}

Settings seen_from_origin(Settings settings, const glm::dvec3& origin) {
  const glm::dvec4 way(origin, 0);
  settings.camera.world_from_camera[3] -= way;
  for (Camera& pose : settings.camera_poses) pose.world_from_camera[3] -= way;
  if (settings.next_camera) settings.next_camera->world_from_camera[3] -= way;
  return settings;
}

}  // namespace eikon
