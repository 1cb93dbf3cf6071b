// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

constexpr std::size_t kSamples = 1000000;
constexpr unsigned kDirections =
    3;  // cosine hemisphere, uniform hemisphere, uniform sphere: outputs 3 k, 3 k + 1, 3 k + 2
const char* const kNames[] = {"cosine hemisphere", "uniform hemisphere", "uniform sphere"};

const std::vector<Words>& independent_samples() {
  static const std::vector<Words> out = [] {
    std::mt19937 random(1);
    Words u, v;
    for (std::size_t i = 0; i < kSamples; ++i) {
      u.push_back(as_word(float(random() >> 8) * 0x1p-24F));
      v.push_back(as_word(float(random() >> 8) * 0x1p-24F));
    }
    return Probe("warp").run("probe_warps", {u, v}, 13);
  }();
  return out;
}

// Share of directions with z below, for each warp.
double share_below(unsigned warp, double z) {
  if (warp == 0) return z <= 0 ? 0 : z * z;
  if (warp == 1) return std::max(z, 0.0);
  return (z + 1) / 2;
}

TEST(Warp, directions_have_the_stated_density) {
  constexpr unsigned kRows = 50, kColumns = 101;  // an odd count has no edges on the axes
  const auto& out = independent_samples();
  for (unsigned warp = 0; warp < kDirections; ++warp) {
    std::vector<double> observed(kRows * kColumns, 0), expected;
    for (unsigned row = 0; row < kRows; ++row) {
      const double share = share_below(warp, 2.0 * (row + 1) / kRows - 1) - share_below(warp, 2.0 * row / kRows - 1);
      expected.insert(expected.end(), kColumns, share * kSamples / kColumns);
    }
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double x = as_float(out[3 * warp][i]), y = as_float(out[3 * warp + 1][i]),
                   z = as_float(out[3 * warp + 2][i]);
      const double turn = std::atan2(y, x) / (2 * std::numbers::pi) + 0.5;
      const auto row = std::min(unsigned((z + 1) / 2 * kRows), kRows - 1);
      const auto column = std::min(unsigned(turn * kColumns), kColumns - 1);
      ++observed[row * kColumns + column];
    }
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(kDirections + 1)) << kNames[warp] << '\n' << test.table;
  }
}

TEST(Warp, points_of_a_triangle_are_uniform_over_its_area) {
  constexpr unsigned kGrid = 20;  // by the area-preserving map of [Turk 1990], independent of the one under test
  const auto& out = independent_samples();
  std::vector<double> observed(kGrid * kGrid, 0);
  const std::vector<double> expected(kGrid * kGrid, double(kSamples) / (kGrid * kGrid));
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double b1 = as_float(out[9][i]), b2 = as_float(out[10][i]), sum = b1 + b2;
    const auto row = std::min(unsigned(sum * sum * kGrid), kGrid - 1);
    const auto column = std::min(unsigned((sum > 0 ? b2 / sum : 0) * kGrid), kGrid - 1);
    ++observed[row * kGrid + column];
  }
  const ChiSquare test = chi_square(observed, expected);
  EXPECT_GT(test.p_value, sidak(kDirections + 1)) << test.table;
}

TEST(Warp, directions_are_unit_to_three_ulp) {
  const auto& out = independent_samples();
  for (unsigned warp = 0; warp < kDirections; ++warp) {
    double worst = 0;
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double x = as_float(out[3 * warp][i]), y = as_float(out[3 * warp + 1][i]),
                   z = as_float(out[3 * warp + 2][i]);
      worst = std::max(worst, std::abs(std::sqrt(x * x + y * y + z * z) - 1));
    }
    EXPECT_LT(worst, 3 * 0x1p-23) << kNames[warp];
  }
}

TEST(Warp, N2_the_ends_of_the_unit_interval_give_finite_directions_of_positive_density) {
  const float last = 1 - 0x1p-24F;
  Words u, v;
  for (const float a : {0.0F, 0x1p-24F, 0.5F - 0x1p-24F, 0.5F, 0.5F + 0x1p-24F, last})
    for (const float b : {0.0F, 0x1p-24F, 0.5F - 0x1p-24F, 0.5F, 0.5F + 0x1p-24F, last, 0.3F}) {
      u.push_back(as_word(a));
      v.push_back(as_word(b));
    }
  const auto out = Probe("warp").run("probe_warps", {u, v}, 13);
  for (std::size_t i = 0; i < u.size(); ++i) {
    for (std::size_t k = 0; k < 13; ++k) ASSERT_TRUE(std::isfinite(as_float(out[k][i]))) << k << " of " << i;
    EXPECT_GT(as_float(out[2][i]), 1e-4F) << "cosine hemisphere, " << i;
    EXPECT_GT(as_float(out[5][i]), 0.0F) << "uniform hemisphere, " << i;
    const float b1 = as_float(out[9][i]), b2 = as_float(out[10][i]);
    EXPECT_GE(b1, 0.0F) << i;
    EXPECT_GE(b2, 0.0F) << i;
    EXPECT_GE(1.0F - b1 - b2, 0.0F) << i;
  }
}

// Neighbouring cells of the square stay neighbours of bounded shape: what stratification needs.
TEST(Warp, cells_of_the_square_stay_compact_on_the_disk_and_on_the_triangle) {
  constexpr int kGrid = 64;
  Words u, v;
  for (int y = 0; y <= kGrid; ++y)
    for (int x = 0; x <= kGrid; ++x) {
      u.push_back(as_word(std::min(float(x) / kGrid, 1 - 0x1p-24F)));
      v.push_back(as_word(std::min(float(y) / kGrid, 1 - 0x1p-24F)));
    }
  const auto out = Probe("warp").run("probe_warps", {u, v}, 13);
  const auto longest_edge = [&](std::size_t first, std::size_t second) {
    double worst = 0;
    for (std::size_t y = 0; y < kGrid; ++y)
      for (std::size_t x = 0; x < kGrid; ++x)
        for (const std::size_t step : {std::size_t{1}, std::size_t{kGrid + 1}}) {
          const std::size_t i = y * (kGrid + 1) + x, j = i + step;
          worst = std::max(worst, std::hypot(double(as_float(out[first][i])) - as_float(out[first][j]),
                                             double(as_float(out[second][i])) - as_float(out[second][j])));
        }
    return worst;
  };
  EXPECT_LT(longest_edge(11, 12), 3.0 / kGrid) << "a square of side 2 holds the disk: edges of 2 grow to less than 3";
  EXPECT_LT(longest_edge(9, 10), 1.2 / kGrid) << "the unit square holds two triangles: edges of 1 grow to sqrt(5)/2";
}

}  // namespace
}  // namespace eikon::test
