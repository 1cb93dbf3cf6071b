// SPDX-License-Identifier: Apache-2.0
// This tells how well a scene's own lights light the surfaces that its camera sees.
#pragma once
#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// The radiance that white paper would have where the scene shows surfaces: the mean of what
/// arrives at the points that a camera sees, over pi, each point counted with at most 1. It is an
/// estimate for defaults: lights cast no shadows, nothing is reflected, and what the points emit
/// themselves does not count. It is +inf if everything seen is unlit or emits, or if lights without
/// an end (emissive planes, formulas) shine. The environment is left out.
/// settings: camera, width, height, culling
[[nodiscard]] double arriving_light(const Scene& scene, const Settings& settings);

}  // namespace eikon
