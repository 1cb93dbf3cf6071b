// SPDX-License-Identifier: Apache-2.0
// Where light paths start and what they are aimed at (kernels/lights/light_path.h).
#pragma once
#include <span>

#include "pack/pack.h"

namespace eikon {

/// True if the material has delta scattering, a mirror's or that of clear glass, or is that of a
/// solid with openings, so that no sampling of lights finds what is lit through it.
[[nodiscard]] bool is_specular_light_target(const Material& material);
/// True if it comes close to that with most of its light: its roughness is at most 0.5. Sampling
/// of lights finds what is lit by it, but the less well the less rough it is.
[[nodiscard]] bool is_glossy_light_target(const Material& material);
/// True if light paths are aimed at it: either of these.
[[nodiscard]] bool is_light_target(const Material& material);
/// True if light paths find some light that no path from the camera does: that of a bulb, a spot or
/// a sun, which no ray meets, by way of a specular target.
[[nodiscard]] bool only_light_paths_find_some(const Scene& scene);

/// True if an environment has lights so small and bright, as the sun is, that paths from the camera
/// which leave glass or a mirror seldom meet what lights the scene.
[[nodiscard]] bool has_small_lights(const EnvironmentMap& map);

/// The power of two among those that emission_aim may have (aim_mark of
/// kernels/lights/light_ratio_word.h) next to another one.
[[nodiscard]] float aim_within_bounds(float aim);

/// A light as the choice of where light paths start sees it.
struct LightPathSource {
  // W / sr: of a surface its mean radiance times its area, else its intensity; 0: none starts.
  double radiance_area = 0;
  double irradiance = 0;     // W / m^2, of parallel light
  double area_m2 = 0;        // of a surface, else 0
  glm::dvec3 place{0.0};     // its middle, if it has one
};

/// Finds the targets, and makes the table that chooses lights in proportion to what they send
/// towards them.
/// emitters  of packed.lights, in their order
void pack_light_paths(std::span<const Material> materials, std::span<const LightPathSource> emitters, PackedScene& packed);

}  // namespace eikon
