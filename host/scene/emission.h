// SPDX-License-Identifier: Apache-2.0
// Which surfaces emit light, and which of them are sampled.
#pragma once
#include "scene/endless.h"
#include "scene/scene.h"

namespace eikon {

[[nodiscard]] inline bool emits(const Material& material) {
  const glm::vec3& emission = material.emission;
  return !material.unlit && (emission.x > 0 || emission.y > 0 || emission.z > 0);
}

[[nodiscard]] inline double mean(const glm::vec3& color) {
  return (double(color.x) + double(color.y) + double(color.z)) / 3;
}

/// True of an environment that gives light; a map counts as one that does.
[[nodiscard]] inline bool shines(const Environment& environment) {
  const glm::vec3& radiance = environment.radiance;
  return environment.map || radiance.x > 0 || radiance.y > 0 || radiance.z > 0;
}

/// True if direct lighting samples a shape. Emissive formulas and planes without end have no area
/// to sample: scattered rays find them, and their light counts in full.
[[nodiscard]] inline bool is_sampled_light(const Shape& shape, const Material& material) {
  return emits(material) && shape.kind != ShapeKind::implicit && !is_endless(shape);
}

}  // namespace eikon
