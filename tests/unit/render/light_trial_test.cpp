// SPDX-License-Identifier: Apache-2.0
// The decision how many light paths an image has, from the sums of a trial.
#include "render/pilot/light_trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace eikon {
namespace {

using Ratios = std::array<double, kLightPathRatios.size()>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

LightTrial trial_of(double camera, const Ratios& shared, double light_rays = 4) {
  return {.camera_error = camera, .shared_error = shared, .camera_rays = 5, .light_rays = light_rays};
}

TEST(LightTrial, second_moments_from_splats_are_those_of_the_balance_heuristic) {
  // Paths of three kinds with the light f, found by camera paths with probability p, and by each of
  // n light paths with q.
  struct Kind {
    double f, p, q;
  };
  const std::array<Kind, 3> kinds = {{{2, 1e-2, 1e-3}, {0.7, 1e-4, 5e-3}, {1.1, 0, 2e-3}}};
  const double pixels = 16, of_trial = 0.25, trial_count = of_trial * pixels;
  Ratios expected{}, found{};
  for (const Kind& kind : kinds) {
    const double ratio = kind.p > 0 ? trial_count * kind.q / kind.p : kInfinite;
    // A splat's value over the number of light paths, with its share; there are n q such splats of
    // each sample index.
    const double value = kind.f / (trial_count * kind.q) * (kind.p > 0 ? ratio / (1 + ratio) : 1);
    const Ratios moments = splat_moments(ratio, of_trial);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double count = kLightPathRatios[i] * pixels;
      expected[i] += kind.f * kind.f / (kind.p + count * kind.q);
      found[i] += trial_count * kind.q * value * value * moments[i];
    }
  }
  EXPECT_TRUE(std::isinf(found[0])) << "camera paths never find the last kind";
  for (std::size_t i = 1; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-12 * expected[i]) << i;
}

TEST(LightTrial, has_no_light_paths_where_they_change_nothing) {
  EXPECT_EQ(best_light_paths(trial_of(100, {})), 0U);
  EXPECT_EQ(best_light_paths(trial_of(100, {2, 1.9, 1.8, 1.5, 1})), 0U) << "less than the cost";
}

TEST(LightTrial, has_more_of_them_the_more_error_they_take_away) {
  EXPECT_EQ(best_light_paths(trial_of(100, {40, 20, 18, 15, 12, 11, 11})), 1U);
  EXPECT_EQ(best_light_paths(trial_of(100, {800, 100, 60, 10, 4, 3, 3})), 3U);
  EXPECT_EQ(best_light_paths(trial_of(1, {kInfinite, 1280, 640, 160, 40, 10, 2.5})), 6U) << "all light comes by them";
  EXPECT_EQ(best_light_paths(trial_of(1, {800, 790, 780, 600, 200, 150, 140})), 4U) << "they fall beside a small view";
}

TEST(LightTrial, always_has_some_where_only_they_find_light) {
  EXPECT_EQ(best_light_paths(trial_of(100, {kInfinite, 0, 0, 0, 0, 0, 0})), 1U);
  EXPECT_EQ(light_path_gain(trial_of(100, {kInfinite, 0, 0, 0, 0, 0, 0}), 1), 0);
  EXPECT_EQ(best_light_paths(trial_of(100, {kInfinite, 400, 200, 50, 30, 30, 30})), 3U);
}

TEST(LightTrial, counts_rays_of_light_paths) {
  const Ratios shared = {100, 70, 50, 20, 10, 9, 9};
  EXPECT_GT(best_light_paths(trial_of(30, shared, 2)), best_light_paths(trial_of(30, shared, 60)));
}

TEST(LightTrial, gains_are_those_of_error_times_cost) {
  const LightTrial trial = trial_of(100, {400, 60, 50, 20, 10, 5, 4});
  EXPECT_EQ(light_path_gain(trial, 0), 1);
  // Twice the rays for a ray of light paths, and 4 % for the weights of camera paths.
  EXPECT_NEAR(light_path_gain(trial, 3), 500 * 5 / (120 * (1.04 * 5 + 2 * 4.0 / 16)), 1e-12);
}

}  // namespace
}  // namespace eikon
