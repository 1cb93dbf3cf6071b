// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/environment/studio.h"

namespace eikon {
namespace {

glm::dvec3 direction_of(const EnvironmentMap& map, std::uint32_t x, std::uint32_t y) {
  const double azimuth = ((x + 0.5) / map.width - 0.5) * 2 * M_PI, polar = (y + 0.5) / map.height * M_PI;
  return {std::sin(azimuth) * std::sin(polar), std::cos(polar), -std::cos(azimuth) * std::sin(polar)};
}

/// The radiance of white paper with a normal.
double paper(const EnvironmentMap& map, const glm::dvec3& normal) {
  double sum = 0;
  for (std::uint32_t y = 0; y < map.height; ++y)
    for (std::uint32_t x = 0; x < map.width; ++x) {
      const glm::dvec3 d = direction_of(map, x, y);
      sum += double(map.radiance[std::size_t{y} * map.width + x].x) * std::max(0.0, glm::dot(d, normal)) *
             std::sqrt(1 - d.y * d.y);
    }
  return sum * (2 * M_PI / map.width) * (M_PI / map.height) / M_PI;
}

TEST(NeutralStudio, exposes_white_paper_and_has_no_colour) {
  const auto map = neutral_studio();
  ASSERT_EQ(map->radiance.size(), std::size_t{map->width} * map->height);
  double brightest = 0, darkest = 1e300;
  for (int i = 0; i < 500; ++i) {  // normals spread by the golden angle
    const double y = 1 - (i + 0.5) / 250, azimuth = i * 2.399963229728653, r = std::sqrt(1 - y * y);
    const double white = paper(*map, {r * std::cos(azimuth), y, r * std::sin(azimuth)});
    brightest = std::max(brightest, white);
    darkest = std::min(darkest, white);
  }
  EXPECT_NEAR(brightest, 1, 0.05);
  EXPECT_GT(darkest, 0.2) << "no side of a shape is black";
  EXPECT_LT(darkest, 0.5) << "sides differ, so that a shape shows";
  for (const glm::vec3& texel : map->radiance) {
    ASSERT_EQ(texel.x, texel.y);
    ASSERT_EQ(texel.y, texel.z);
    ASSERT_TRUE(texel.x > 0.1F && texel.x < 6);
  }
}

TEST(NeutralStudio, is_smooth_and_has_no_seam) {
  const auto map = neutral_studio();
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return map->radiance[std::size_t{y} * map->width + x].x; };
  for (std::uint32_t y = 0; y < map->height; ++y)
    for (std::uint32_t x = 0; x < map->width; ++x) {
      ASSERT_NEAR(at(x, y), at((x + 1) % map->width, y), 0.3);
      ASSERT_NEAR(at(x, y), at(x, y == 0 ? y : y - 1), 0.3);
    }
}

}  // namespace
}  // namespace eikon
