// SPDX-License-Identifier: Apache-2.0
#include "image/tonemap.h"

#include <algorithm>

namespace eikon {
namespace {

/// Makes a matrix from its rows.
glm::dmat3 rows(const glm::dvec3& r0, const glm::dvec3& r1, const glm::dvec3& r2) {
  return glm::transpose(glm::dmat3(r0, r1, r2));
}

glm::dvec3 to_unit(const glm::dvec3& v) { return glm::clamp(v, 0.0, 1.0); }

glm::dvec3 reinhard(const glm::dvec3& linear) {
  return linear / (1.0 + luminance(linear));
}

// This is Hill's scale, without the factor 1/0.6 of three.js: white, 1, becomes 0.62.
glm::dvec3 aces(const glm::dvec3& linear) {
  const glm::dmat3 rrt_from_rec709 =  // sRGB => XYZ => D65 to D60 => AP1 => saturation of the RRT
      rows({0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777});
  const glm::dmat3 rec709_from_odt =  // saturation of the ODT => XYZ => D60 to D65 => sRGB
      rows({1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602});
  const glm::dvec3 v = rrt_from_rec709 * linear;
  const glm::dvec3 curve = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
  return to_unit(rec709_from_odt * curve);
}

// The version with Rec. 2020 primaries, as Filament (ToneMapper.cpp) and three.js have it.
glm::dvec3 agx(const glm::dvec3& linear) {
  const glm::dmat3 rec2020_from_rec709 =
      rows({0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0113}, {0.0164, 0.0880, 0.8956});
  const glm::dmat3 rec709_from_rec2020 =
      rows({1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187});
  const glm::dmat3 inset = rows({0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                                {0.137318972929847, 0.761241990602591, 0.101439036467562},
                                {0.11189821299995, 0.0767994186031903, 0.811302368396859});
  const glm::dmat3 outset = rows({1.1271005818144368, -0.11060664309660323, -0.016493938717834573},
                                 {-0.1413297634984383, 1.157823702216272, -0.016493938717834257},
                                 {-0.14132976349843826, -0.11060664309660294, 1.2519364065950405});
  // 10 stops below middle grey, 0.18, and 6.5 above.
  constexpr double least_ev = -12.47393, most_ev = 4.026069;
  const glm::dvec3 stops = glm::log2(glm::max(inset * (rec2020_from_rec709 * linear), 1e-10));
  const glm::dvec3 x = to_unit((stops - least_ev) / (most_ev - least_ev));
  // The default contrast, a fit [Benjamin Wrensch, "Minimal AgX Implementation"]: mean squared
  // error 3.7e-6.
  const glm::dvec3 contrast =
      -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
  const glm::dvec3 display = glm::pow(glm::max(outset * contrast, 0.0), glm::dvec3(2.2));
  return to_unit(rec709_from_rec2020 * display);
}

glm::dvec3 pbr_neutral(const glm::dvec3& linear) {
  constexpr double fresnel = 0.04;  // F90 of the paper: what a dielectric reflects face on
  constexpr double begin = 0.8 - fresnel, room = 1 - begin, desaturation = 0.15;
  const double least = std::min({linear.x, linear.y, linear.z});
  const glm::dvec3 colour = linear - (least < 2 * fresnel ? least - 6.25 * least * least : fresnel);
  const double peak = std::max({colour.x, colour.y, colour.z});
  if (peak < begin) return colour;
  const double compressed = 1 - room * room / (peak + room - begin);
  const double to_white = 1 - 1 / (desaturation * (peak - compressed) + 1);
  return glm::mix(colour * (compressed / peak), glm::dvec3(compressed), to_white);
}

}  // namespace

const std::vector<std::string>& tone_map_names() {
  static const std::vector<std::string> names = {"none", "reinhard", "aces", "agx", "pbr-neutral"};  // as in ToneMap
  return names;
}

const std::string& name_of(ToneMap map) { return tone_map_names().at(std::size_t(map)); }

std::optional<ToneMap> tone_map_of(std::string_view name) {
  const auto& names = tone_map_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<ToneMap>(found - names.begin());
}

glm::dvec3 tone_map(ToneMap map, const glm::dvec3& linear) {
  const glm::dvec3 positive = glm::max(linear, 0.0);
  switch (map) {
    case ToneMap::reinhard:
      return reinhard(positive);
    case ToneMap::aces:
      return aces(positive);
    case ToneMap::agx:
      return agx(positive);
    case ToneMap::pbr_neutral:
      return pbr_neutral(positive);
    case ToneMap::none:
      break;
  }
  return linear;
}

}  // namespace eikon
