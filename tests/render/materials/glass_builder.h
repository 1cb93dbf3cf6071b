// SPDX-License-Identifier: Apache-2.0
// Glass in scenes of known answer, and beams that measure it.
#pragma once
#include "render/scene_builder.h"

namespace eikon::test {

inline Material glass(float ior, float roughness, bool solid) {
  Material m;
  m.metallic = 0;
  m.roughness = roughness;
  m.ior = ior;
  m.transmission = 1;
  m.solid = solid;
  return m;
}

inline Material ranked(Material m, int priority) {
  m.medium_priority = priority;
  return m;
}

inline void add_block(Scene& scene, const char* name, glm::vec3 lo, glm::vec3 hi, const Material& m) {
  Primitive box;
  add_box(box, lo, hi, false);
  add_mesh(scene, name, std::move(box), m);
}

/// Clear glass but for Beer's law: `per_metre` is left after a metre.
inline Material amber(float per_metre, float ior) {
  Material m = glass(ior, 0, true);
  m.attenuation_color = glm::vec3(per_metre);
  m.attenuation_distance = 1;
  return m;
}

/// Parallel rays from `eye` to `target`, so close together that all of them are one.
inline Camera beam(const glm::dvec3& eye, const glm::dvec3& target) {
  const glm::dvec3 up =
      std::abs(target.y - eye.y) > 0.9 * glm::length(target - eye) ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  Camera camera = look_at_camera(eye, target, up, 1);
  camera.projection = Projection::orthographic;
  camera.ymag_m = 1e-4;
  return camera;
}

/// A few samples of one beam, without roulette: delta surfaces alone give each sample the same
/// value but for their choices.
inline Settings settings_for_beam(const glm::dvec3& eye, const glm::dvec3& target, std::uint64_t spp) {
  Settings settings = settings_for(4, 4, spp);
  settings.camera = beam(eye, target);
  settings.roulette_depth = 1000;
  return settings;
}

/// A wall at z = -5 that emits 1 towards +z.
inline void add_lamp(Scene& scene) {
  Primitive wall;
  add_quad(wall, {-50, -50, -5}, {100, 0, 0}, {0, 100, 0});
  add_mesh(scene, "lamp", std::move(wall), lambert(0, 1));
}

}  // namespace eikon::test
