// SPDX-License-Identifier: Apache-2.0
// The starts of light paths have the densities that they state.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "kernels/lights/light_path_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kPathCount = 1 << 19;

/// Two balls that overlap as seen from the origin, a small one, and a large one far away.
const std::vector<float4> kTargets = {{2, 0, 0, 0.8F}, {3, 1, 0.5F, 1}, {-1, -2, 1, 0.2F}, {0, 30, 5, 9}};

/// The same words for each item, then three random numbers.
std::vector<Words> inputs(const glm::vec3& fixed) {
  std::mt19937 random(5);
  std::vector<Words> in(6);
  for (std::size_t i = 0; i < kPathCount; ++i) {
    for (int c = 0; c < 3; ++c) in[std::size_t(c)].push_back(as_word(fixed[c]));
    for (std::size_t c = 3; c < 6; ++c) in[c].push_back(as_word(uniform(random)));
  }
  return in;
}

/// Density of directions: the cones that one lies in, over the sum of their solid angles.
double density(const glm::dvec3& from, const glm::dvec3& dir) {
  double solid_angle = 0, met = 0;
  for (const float4& ball : kTargets) {
    const glm::dvec3 way = glm::dvec3(ball.x, ball.y, ball.z) - from;
    const double sine = double(ball.w) / glm::length(way);
    const double cosine = sine < 1 ? std::sqrt(1 - sine * sine) : -1;
    solid_angle += 2 * kPi * (1 - cosine);
    met += glm::dot(dir, glm::normalize(way)) >= cosine ? 1 : 0;
  }
  return met / solid_angle;
}

TEST(LightPath, directions_have_the_density_that_they_state) {
  constexpr int kRows = 24, kColumns = 48, kFine = 96;
  const glm::dvec3 places[] = {{0, 0, 0}, {2.5, 0.5, 0.25}};  // the second one lies in two of the balls
  for (const glm::dvec3& from : places) {
    const std::vector<Words> out =
        light_path_probe(kTargets).run("probe_target_directions", inputs(glm::vec3(from)), 5);
    std::vector<double> observed(kRows * kColumns), expected(kRows * kColumns);
    for (int i = 0; i < kRows * kFine; ++i)
      for (int j = 0; j < kColumns * kFine; ++j) {
        const double z = 1 - 2 * (i + 0.5) / (kRows * kFine), phi = 2 * kPi * (j + 0.5) / (kColumns * kFine);
        const double r = std::sqrt(1 - z * z), cell = 4 * kPi / (kRows * kFine * kColumns * kFine);
        expected[std::size_t(i / kFine * kColumns + j / kFine)] +=
            double(kPathCount) * cell * density(from, {r * std::cos(phi), r * std::sin(phi), z});
      }
    for (std::size_t i = 0; i < kPathCount; ++i) {
      const glm::dvec3 dir(as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i]));
      ASSERT_NEAR(glm::length(dir), 1, 1e-6);
      const double turn = std::atan2(dir.y, dir.x) / (2 * kPi);
      const int row = std::min(int((1 - dir.z) / 2 * kRows), kRows - 1);
      const int column = std::min(int((turn < 0 ? turn + 1 : turn) * kColumns), kColumns - 1);
      ++observed[std::size_t(row * kColumns + column)];
      const double stated = double(as_float(out[3][i]));
      ASSERT_GT(stated, 0);
      // Rims of cones are a matter of rounding.
      if (std::abs(stated - density(from, dir)) > 1e-4 * stated) {
        const glm::dvec3 aside = glm::normalize(dir + 1e-4 * glm::dvec3(0.3, -0.5, 0.8));
        const glm::dvec3 other = glm::normalize(dir - 1e-4 * glm::dvec3(0.3, -0.5, 0.8));
        EXPECT_TRUE(density(from, aside) != density(from, other)) << "sample " << i;
      }
    }
    for (double& count : expected) count += 1e-9;  // bins that a rim grazes are pooled with others
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(2)) << test.table;
  }
}

TEST(LightPath, parallel_light_starts_evenly_on_the_discs) {
  const glm::dvec3 dir = glm::normalize(glm::dvec3(0.2, -1, 0.3));
  const std::vector<Words> out = light_path_probe(kTargets).run("probe_target_origins", inputs(glm::vec3(dir)), 5);
  // 1 / density is the area that the discs cover together, in the mean, however they overlap.
  double sections = 0;
  for (const float4& ball : kTargets) sections += kPi * double(ball.w) * double(ball.w);
  std::vector<double> observed(kTargets.size());
  int others = 0;  // samples whose density is not that of the discs that they lie on
  for (std::size_t i = 0; i < kPathCount; ++i) {
    const glm::dvec3 origin(as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i]));
    double met = 0;
    for (std::size_t k = 0; k < kTargets.size(); ++k) {
      const glm::dvec3 way = glm::dvec3(kTargets[k].x, kTargets[k].y, kTargets[k].z) - origin;
      EXPECT_GT(glm::dot(way, dir), double(kTargets[k].w)) << "it begins before the ball";
      const double distance = glm::length(way - dir * glm::dot(way, dir));
      met += distance <= double(kTargets[k].w) * (1 + 1e-5) ? 1 : 0;
      // The inner half of each disc's area: a ring and a core of equal shares.
      if (distance <= double(kTargets[k].w) * std::numbers::sqrt2 / 2) ++observed[k];
    }
    others += std::abs(double(as_float(out[3][i])) * sections - std::max(met, 1.0)) > 1e-3 ? 1 : 0;
  }
  EXPECT_LT(others, 300) << "the way back to the origin rounds, so that few on a rim are told apart otherwise";
  // From this side no discs overlap but those of the first two balls.
  for (std::size_t k = 2; k < kTargets.size(); ++k) {
    const double share = 0.5 * kPi * double(kTargets[k].w) * double(kTargets[k].w) / sections;
    const double sigma = std::sqrt(share * (1 - share) * double(kPathCount));
    EXPECT_NEAR(observed[k], share * double(kPathCount), 4 * sigma) << k;
  }
}

}  // namespace
}  // namespace eikon::test
