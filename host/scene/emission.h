// SPDX-License-Identifier: Apache-2.0
// What gives off light.
#pragma once
#include "scene/endless.h"
#include "scene/scene.h"

namespace eikon {

[[nodiscard]] inline bool emits(const Material& material) {
  const glm::vec3& emission = material.emission;
  return !material.unlit && (emission.x > 0 || emission.y > 0 || emission.z > 0);
}

/// True of an environment that gives light; a map counts as one that does.
[[nodiscard]] inline bool shines(const Environment& environment) {
  const glm::vec3& radiance = environment.radiance;
  return environment.map || radiance.x > 0 || radiance.y > 0 || radiance.z > 0;
}

/// Whether shading points choose a shape among the lights. What emits but has no area to choose points of (formulas, planes without
/// end) is no light to sample: scattered rays find it, and it counts in full.
[[nodiscard]] inline bool is_sampled_light(const Shape& shape, const Material& material) {
  return emits(material) && shape.kind != ShapeKind::implicit && !is_endless(shape);
}

}  // namespace eikon
