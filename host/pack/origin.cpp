// SPDX-License-Identifier: Apache-2.0
#include "pack/origin.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "pack/pack_parts.h"
#include "scene/endless.h"
#include "scene/shape.h"

namespace eikon {
namespace {

// A scene is far if its centre is so many times half its diagonal away. Nearer ones lose little,
// and keep the coordinates of their file.
constexpr double kFar = 32;
// Things that are this share of a scene's surfaces may be anywhere: files from surveys often have a
// node that was left at the origin, and in an animation something may fly off.
constexpr double kStrayShare = 0.05;

/// A node or a shape.
struct Part {
  Bounds bounds;        // around it, in the world
  double surfaces = 1;  // its triangles; 1 for a shape
  [[nodiscard]] glm::dvec3 center() const { return 0.5 * (bounds.lo + bounds.hi); }
};

/// All that has a place in the world.
std::vector<Part> parts_of(const Scene& scene) {
  std::vector<double> surfaces_of_mesh;
  for (const Mesh& mesh : scene.meshes) {
    double surfaces = 0;
    for (const Primitive& primitive : mesh.primitives) surfaces += double(primitive.indices.triangle_count());
    surfaces_of_mesh.push_back(surfaces);
  }
  const std::vector<Bounds> boxes = boxes_of_nodes(scene);
  std::vector<Part> parts;
  parts.reserve(scene.nodes.size() + scene.shapes.size());
  for (std::size_t n = 0; n < boxes.size(); ++n)
    if (!boxes[n].empty()) parts.push_back({.bounds = boxes[n], .surfaces = surfaces_of_mesh[scene.nodes[n].mesh]});
  for (const Shape& shape : scene.shapes) {
    const OwnShape own = own_shape(is_endless(shape) ? bounded_piece(shape) : shape);
    parts.push_back({.bounds = {own.center - own.half, own.center + own.half}, .surfaces = 1});
  }
  return parts;
}

Bounds bounds_of(const std::vector<Part>& parts) {
  Bounds bounds;
  for (const Part& part : parts) grow(bounds, part.bounds.lo), grow(bounds, part.bounds.hi);
  return bounds;
}

/// The range of the parts' middles on an axis, but for those that lie farthest out: kStrayShare of
/// the surfaces in all.
std::pair<double, double> range_of_most(const std::vector<Part>& parts, int axis) {
  struct Middle {
    double at, surfaces;
  };
  std::vector<Middle> middles;
  middles.reserve(parts.size());
  double surfaces = 0;
  for (const Part& part : parts) {
    middles.push_back({part.center()[axis], part.surfaces});
    surfaces += part.surfaces;
  }
  std::ranges::sort(middles, {}, &Middle::at);
  std::size_t median = 0;
  for (double below = middles[0].surfaces; below < 0.5 * surfaces && median + 1 < middles.size();)
    below += middles[++median].surfaces;
  std::size_t first = 0, last = middles.size() - 1;
  double left = kStrayShare * surfaces;
  for (bool is_low_open = true, is_high_open = true;;) {
    is_low_open = is_low_open && first < median && middles[first].surfaces <= left;
    is_high_open = is_high_open && last > median && middles[last].surfaces <= left;
    if (!is_low_open && !is_high_open) return {middles[first].at, middles[last].at};
    // If both ends may go, the one that is farther out goes first.
    const bool is_low = is_low_open && (!is_high_open ||
                                        middles[median].at - middles[first].at > middles[last].at - middles[median].at);
    left -= middles[is_low ? first : last].surfaces;
    is_low ? ++first : --last;
  }
}

/// A box around the parts but for those that lie farthest out along an axis.
Bounds bounds_of_most(const std::vector<Part>& parts) {
  Bounds most;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [first, last] = range_of_most(parts, axis);
    for (const Part& part : parts) {
      if (part.center()[axis] < first || part.center()[axis] > last) continue;
      most.lo[axis] = std::min(most.lo[axis], part.bounds.lo[axis]);
      most.hi[axis] = std::max(most.hi[axis], part.bounds.hi[axis]);
    }
  }
  return most;
}

bool is_far(const Bounds& bounds) {
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  return glm::length(center) > kFar * 0.5 * glm::length(bounds.hi - bounds.lo);
}

/// True if a camera of the file is nearer to the middle of the bounds than to the origin, or if the
/// file has none.
bool is_seen_from_near(const Bounds& bounds, const Scene& scene) {
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  return scene.cameras.empty() || std::ranges::any_of(scene.cameras, [&](const Camera& camera) {
           const glm::dvec3 eye(camera.world_from_camera[3]);
           return glm::distance(eye, center) < glm::length(eye);
         });
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

std::vector<Bounds> boxes_of_nodes(const Scene& scene) {
  std::vector<Bounds> boxes, own_boxes(scene.meshes.size());
  boxes.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) {
    Bounds& own = own_boxes[node.mesh];
    if (own.empty())
      for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
        for (const glm::vec3& p : primitive.positions_object) grow(own, glm::dvec3(p));
    grow(boxes.emplace_back(), node.world_from_object, own);
  }
  return boxes;
}

glm::dvec3 origin_of(const Scene& scene, std::span<const glm::dvec3> more) {
  const std::vector<Part> parts = parts_of(scene);
  Bounds bounds = bounds_of(parts);
  for (const glm::dvec3& point : more) grow(bounds, point);
  if (bounds.empty()) return glm::dvec3(0);
  if (!is_far(bounds) && parts.size() > 1) {
    bounds = bounds_of_most(parts);
    for (const glm::dvec3& point : more) grow(bounds, point);
    if (!is_seen_from_near(bounds, scene)) return glm::dvec3(0);
  }
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  const double radius = 0.5 * glm::length(bounds.hi - bounds.lo), away = glm::length(center);
  if (!is_far(bounds) || !std::isfinite(away)) return glm::dvec3(0);
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
