// SPDX-License-Identifier: Apache-2.0
#include "scene/environment/studio.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eikon {
namespace {

constexpr std::uint32_t kHeight = 128, kWidth = 2 * kHeight;

/// A round light whose edge is as soft as it is wide.
struct SoftLight {
  glm::dvec3 towards;   // of any length
  double inner, outer;  // cosines of the angles at which it is full and gone
  double radiance;      // W / (sr m^2), on top of the room's
};

constexpr SoftLight kLights[] = {
    {.towards = {-0.55, 0.60, 0.80}, .inner = 0.97, .outer = 0.74, .radiance = 2.1},
    {.towards = {0.95, 0.30, 0.45}, .inner = 0.96, .outer = 0.65, .radiance = 0.55},
    {.towards = {0.35, 0.50, -0.95}, .inner = 0.97, .outer = 0.78, .radiance = 1.3},
};
constexpr double kFloor = 0.28, kCeiling = 0.45;  // radiance straight down and straight up

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double radiance_from(const glm::dvec3& direction) {
  double radiance = kFloor + (kCeiling - kFloor) * smoothstep(-1, 1, direction.y);
  for (const SoftLight& light : kLights)
    radiance +=
        light.radiance * smoothstep(light.outer, light.inner, glm::dot(direction, glm::normalize(light.towards)));
  return radiance;
}

}  // namespace

std::shared_ptr<const EnvironmentMap> neutral_studio() {
  auto map = std::make_shared<EnvironmentMap>();
  map->name = "neutral";
  map->width = kWidth;
  map->height = kHeight;
  map->radiance.reserve(std::size_t{kWidth} * kHeight);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const double azimuth = ((x + 0.5) / kWidth - 0.5) * 2 * std::numbers::pi;
      const double polar = (y + 0.5) / kHeight * std::numbers::pi;
      const glm::dvec3 direction(std::sin(azimuth) * std::sin(polar), std::cos(polar),
                                 -std::cos(azimuth) * std::sin(polar));
      // Steps of 2^-12 hide the last digits of sines, which differ among mathematical libraries.
      map->radiance.emplace_back(float(std::round(radiance_from(direction) * 0x1p12) * 0x1p-12));
    }
  return map;
}

}  // namespace eikon
