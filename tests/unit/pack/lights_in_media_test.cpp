// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/lights_in_media.h"

#include <gtest/gtest.h>

#include <random>

namespace eikon {
namespace {

using RealCorners = std::array<glm::dvec3, 3>;

/// True if an edge of one passes through the inside of the other.
bool pierces(const RealCorners& edges_of, const RealCorners& through) {
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 p = edges_of[k], d = edges_of[(k + 1) % 3] - p;
    const glm::dmat3 m(through[1] - through[0], through[2] - through[0], -d);
    const glm::dvec3 solution = glm::inverse(m) * (p - through[0]);
    if (solution.x >= 0 && solution.y >= 0 && solution.x + solution.y <= 1 && solution.z >= 0 && solution.z <= 1)
      return true;
  }
  return false;
}

TEST(LightsInMedia, triangles_meet_where_an_edge_of_one_passes_through_the_other) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int met = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::array<RealCorners, 2> two;
    for (RealCorners& corners : two)
      for (glm::dvec3& corner : corners) corner = {uniform(random), uniform(random), uniform(random)};
    const bool expected = pierces(two[0], two[1]) || pierces(two[1], two[0]);
    ASSERT_EQ(triangles_meet(two[0], two[1]), expected) << i;
    met += expected ? 1 : 0;
  }
  EXPECT_GT(met, 1'000);
}

TEST(LightsInMedia, triangles_of_one_plane_meet_where_they_overlap) {
  const RealCorners large{glm::dvec3(0, 0, 1), glm::dvec3(4, 0, 1), glm::dvec3(0, 4, 1)};
  const auto small_at = [](double x, double y) {
    return RealCorners{glm::dvec3(x, y, 1), glm::dvec3(x + 0.5, y, 1), glm::dvec3(x, y + 0.5, 1)};
  };
  EXPECT_TRUE(triangles_meet(large, small_at(1, 1)));
  EXPECT_TRUE(triangles_meet(large, small_at(1.9, 1.9)));
  EXPECT_FALSE(triangles_meet(large, small_at(2.1, 2.1))) << "their boxes overlap";
  EXPECT_FALSE(triangles_meet(large, small_at(-1, 0)));
}

}  // namespace
}  // namespace eikon
