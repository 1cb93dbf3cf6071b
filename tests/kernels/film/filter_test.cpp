// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "film/pixel_filter.h"

namespace eikon::test {
namespace {

constexpr const char* kFilters[] = {"box:3", "triangle", "gaussian", "mitchell", "blackman-harris", "gaussian:0.5"};
constexpr std::size_t kBins = 60;

/// Integral of |f| over each of kBins equal parts of its width, of a total of 1.
std::vector<double> shares(const PixelFilter& filter) {
  std::vector<double> share(kBins, 0);
  double total = 0;
  constexpr int kSteps = 2000;
  for (std::size_t b = 0; b < kBins; ++b)
    for (int i = 0; i < kSteps; ++i) {
      const double at = (double(b) + (i + 0.5) / kSteps) / kBins;
      share[b] += std::abs(filter(filter.width * (at - 0.5)));
    }
  for (const double s : share) total += s;
  for (double& s : share) s /= total;
  return share;
}

std::vector<double> histogram(const PixelFilter& filter, const Words& offsets) {
  std::vector<double> counts(kBins, 0);
  for (const std::uint32_t word : offsets) {
    const double at = double(as_float(word)) / filter.width + 0.5;
    EXPECT_TRUE(at >= 0 && at <= 1);
    counts[std::min(std::size_t(at * kBins), kBins - 1)] += 1;
  }
  return counts;
}

std::vector<Words> sampled(const PixelFilter& filter, const Words& u) {
  return Probe("filter").buffer("filter_table", filter_table(filter)).run("probe_filter", {u}, 2);
}

TEST(Filter, random_places_have_the_filter_s_density) {
  std::mt19937 random(41);
  Words u(1U << 18);
  for (std::uint32_t& word : u) word = as_word(float(random() >> 8) * 0x1p-24F);
  for (const char* name : kFilters) {
    const PixelFilter filter = parse_filter(name);
    std::vector<double> expected = shares(filter);
    for (double& e : expected) e *= double(u.size());
    const ChiSquare test = chi_square(histogram(filter, sampled(filter, u)[0]), expected);
    EXPECT_GT(test.p_value, sidak(std::size(kFilters))) << name << "\n" << test.table;
  }
}

// Nothing but the table stands between even numbers and the filter; it is coarsest where mitchell
// passes 0. Even numbers give even shares, in order, and signs as the filter has them.
TEST(Filter, even_numbers_become_places_as_the_filter_weighs_them) {
  Words u;
  for (std::uint32_t i = 0; i < 1U << 18; ++i) u.push_back(as_word(float(64 * i + 32) * 0x1p-24F));
  for (const char* name : kFilters) {
    const PixelFilter filter = parse_filter(name);
    const auto out = sampled(filter, u);
    const std::vector<double> counts = histogram(filter, out[0]), expected = shares(filter);
    for (std::size_t b = 0; b < kBins; ++b)
      EXPECT_NEAR(counts[b] / double(u.size()), expected[b], 5e-5) << name << " " << b;
    double weights = 0, previous = -filter.width;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double x = double(as_float(out[0][i])), weight = double(as_float(out[1][i]));
      weights += weight;
      EXPECT_GE(x, previous - 1e-6) << name;
      previous = x;
      if (std::abs(filter(x)) > 1e-5) {
        ASSERT_EQ(weight > 0, filter(x) > 0) << name << " at " << x;
      }
    }
    EXPECT_NEAR(weights / double(u.size()), 1, 2e-5) << name;
  }
}

TEST(Filter, ends_of_the_interval_are_the_rims) {
  const Words u = {as_word(0), as_word(0.5F), as_word(1 - 0x1p-24F), as_word(0.5F - 0x1p-24F)};
  for (const char* name : kFilters) {
    const PixelFilter filter = parse_filter(name);
    const Words x = sampled(filter, u)[0];
    EXPECT_EQ(double(as_float(x[0])), -filter.width / 2);
    EXPECT_NEAR(double(as_float(x[1])), 0, 1e-6 * filter.width);
    EXPECT_GE(double(as_float(x[2])), 0.45 * filter.width);
    EXPECT_LE(double(as_float(x[2])), 0.5 * filter.width);
    EXPECT_NEAR(double(as_float(x[3])), 0, 1e-6 * filter.width);
  }
}

}  // namespace
}  // namespace eikon::test
