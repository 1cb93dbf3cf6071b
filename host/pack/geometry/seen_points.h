// SPDX-License-Identifier: Apache-2.0
// This finds the surfaces that a camera sees, on a coarse grid and without a device. They decide
// defaults, such as whether a scene needs light, and never a pixel.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// A triangle of a node, in the world. A shape is shown by the box around it, whose triangles have
/// no `primitive`.
struct WorldTriangle {
  glm::dvec3 corners[3];  // world, metres
  std::uint32_t material = 0;
  const Primitive* primitive = nullptr;
  std::uint32_t index = 0;  // of the primitive's triangles
  bool mirrored = false;    // by its node: corners are in the file's order, so the front is on the other side
};

/// Calls `visit` for each triangle that the scene shows, in an order that is always the same.
void for_each_triangle(const Scene& scene, const std::function<void(const WorldTriangle&)>& visit);

/// The triangle's unit normal on its front, as the file winds it; zero where it has no area.
[[nodiscard]] glm::dvec3 front_normal(const WorldTriangle& triangle);

/// Mean radiance over R, G and B that the triangle emits at barycentrics (1 - u - v, u, v), its
/// texture included.
[[nodiscard]] double emission_at(const Scene& scene, const WorldTriangle& triangle, double u, double v);

/// True if light passes the triangle there, by the opacity of its material, texture and colours.
[[nodiscard]] bool is_clear_at(const Scene& scene, const WorldTriangle& triangle, double u, double v);

struct SeenPoint {
  glm::dvec3 position{};  // world, metres
  glm::dvec3 normal{};    // unit, on the viewer's side
  double emission = 0;    // mean radiance over R, G and B that it emits itself
  bool unlit = false;     // shows its colour without light
};

/// The surfaces at the middles of the pixels of a picture of about a thousand pixels. Pixels that
/// show no surface have no point. A lens counts as a pinhole. settings: camera, width, height,
/// culling
[[nodiscard]] std::vector<SeenPoint> seen_points(const Scene& scene, const Settings& settings);

}  // namespace eikon
