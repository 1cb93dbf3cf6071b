// SPDX-License-Identifier: Apache-2.0
// Tone curves: they map scene-linear radiance to the range of a display.
#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

enum class ToneMap {
  none,      // no change: the encoding clips values beyond the range of the display
  // Luminance L becomes L / (1 + L) [Reinhard et al. 2002, "Photographic Tone Reproduction", eq. 3]
  reinhard,
  // Fit of the ACES reference rendering and sRGB output transforms [Stephen Hill; MJP, BakingLab,
  // ACES.hlsl]
  aces,
  agx,       // AgX, base look [Troy Sobotka], as in Blender, Filament and three.js
  pbr_neutral,  // Khronos PBR Neutral [KhronosGroup/ToneMapping, PBR_Neutral]
};

/// The names for the command line: "none", "reinhard", "aces", "agx", "pbr-neutral".
[[nodiscard]] const std::vector<std::string>& tone_map_names();
/// Returns nothing for another name.
[[nodiscard]] std::optional<ToneMap> tone_map_of(std::string_view name);

[[nodiscard]] const std::string& name_of(ToneMap map);

/// Luminance of a linear Rec. 709 colour.
[[nodiscard]] inline double luminance(const glm::dvec3& linear) {
  return glm::dot(linear, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// linear   Rec. 709 after exposure; negative values, which a pixel filter may leave, count as 0
/// returns  linear Rec. 709 for the sRGB encoding, within [0, 1] except for `none` and for colours
///          of reinhard outside of the gamut
[[nodiscard]] glm::dvec3 tone_map(ToneMap map, const glm::dvec3& linear);

}  // namespace eikon
