// SPDX-License-Identifier: Apache-2.0
#include "instruments/power_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace eikon {
namespace {

struct Points {
  std::vector<double> x, y;
};

/// y = x^before up to `bend`, x^after beyond, with relative noise, at x = 1, 2, 4, ...
Points draw(int count, double before, double after, double bend, double noise, std::mt19937& random) {
  Points points;
  for (int i = 0; i < count; ++i) {
    const double x = std::exp2(i), clear = x <= bend ? std::pow(x, before) : std::pow(bend, before) * std::pow(x / bend, after);
    points.x.push_back(x);
    points.y.push_back(clear * std::exp(std::normal_distribution<double>(0, noise)(random)));
  }
  return points;
}

TEST(PowerLaw, of_an_exact_one_is_exact) {
  std::mt19937 random(1);
  const Points points = draw(5, -1.5, -1.5, 1, 0, random);
  const auto law = fit_power_law(points.x, points.y);
  ASSERT_TRUE(law);
  EXPECT_NEAR(law->exponent.value, -1.5, 1e-12);
  EXPECT_NEAR(law->exponent.doubt, 0, 1e-12);
  EXPECT_FALSE(law->bend);
  EXPECT_EQ(in_words(*law), "-1.50 +- 0.00");
}

TEST(PowerLaw, takes_three_points) {
  const std::vector<double> two = {1, 2}, three = {1, 2, 4};
  EXPECT_FALSE(fit_power_law(two, two));
  EXPECT_TRUE(fit_power_law(three, three));
}

// 95 % of 2,000 intervals, within four standard deviations of a binomial count (0.5 %); also with
// one degree of freedom.
TEST(PowerLaw, intervals_hold_the_exponent) {
  std::mt19937 random(2);
  for (const int count : {3, 4, 7}) {
    int held = 0;
    for (int run = 0; run < 2000; ++run) {
      const Points points = draw(count, -1, -1, 1, 0.05, random);
      const Exponent found = fit_power_law(points.x, points.y)->exponent;
      held += std::abs(found.value + 1) <= found.doubt ? 1 : 0;
    }
    EXPECT_NEAR(held, 1900, 40) << count << " points";
  }
}

TEST(PowerLaw, finds_a_bend_and_none_where_there_is_none) {
  std::mt19937 random(3);
  int found = 0, invented = 0;
  for (int run = 0; run < 500; ++run) {
    const Points bent = draw(10, -1.5, -1, 16, 0.02, random), straight = draw(10, -1, -1, 1, 0.1, random);
    const auto law = fit_power_law(bent.x, bent.y);
    if (law->bend && law->bend->x >= 8 - 1e-9 && law->bend->x <= 32 + 1e-9) {
      ++found;
      EXPECT_NEAR(law->bend->before.value, -1.5, 0.15);
      EXPECT_NEAR(law->bend->after.value, -1, 0.1);
    }
    invented += fit_power_law(straight.x, straight.y)->bend ? 1 : 0;
  }
  EXPECT_GT(found, 480);
  EXPECT_LE(invented, 14) << "1 % of 500, and four standard deviations";
}

}  // namespace
}  // namespace eikon
