// SPDX-License-Identifier: Apache-2.0
// From scene-linear radiance to what a display can show.
#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

enum class ToneMap {
  none,      // no change: what exceeds the display's range is cut off by the encoding
  reinhard,  // luminance L becomes L / (1 + L) [Reinhard et al. 2002, "Photographic Tone Reproduction", eq. 3]
  aces,      // fit of the ACES reference rendering and sRGB output transforms [Stephen Hill; MJP, BakingLab, ACES.hlsl]
  agx,       // AgX, base look [Troy Sobotka], as in Blender, Filament and three.js
  pbr_neutral,  // Khronos PBR Neutral [KhronosGroup/ToneMapping, PBR_Neutral]
};

/// The names of the command line: "none", "reinhard", "aces", "agx", "pbr-neutral".
[[nodiscard]] const std::vector<std::string>& tone_map_names();
/// Nothing for a name that is not one of them.
[[nodiscard]] std::optional<ToneMap> tone_map_of(std::string_view name);

/// linear   Rec. 709, exposure applied; negative values, which a filter may leave, count as 0
/// returns  linear Rec. 709 for the sRGB encoding; except with none and for colours of reinhard outside the display's gamut,
///          within [0, 1]
[[nodiscard]] glm::dvec3 tone_map(ToneMap map, const glm::dvec3& linear);

}  // namespace eikon
