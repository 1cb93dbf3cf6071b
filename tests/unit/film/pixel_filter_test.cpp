// SPDX-License-Identifier: Apache-2.0
#include "film/pixel_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "shared/records.h"

namespace eikon {
namespace {

TEST(PixelFilter, names_and_widths_are_those_of_the_command_line) {
  EXPECT_TRUE(parse_filter("box").is_pixel_box());
  EXPECT_TRUE(parse_filter("box:1").is_pixel_box());
  EXPECT_FALSE(parse_filter("box:2").is_pixel_box());
  EXPECT_FALSE(parse_filter("triangle:1").is_pixel_box());
  EXPECT_EQ(parse_filter("triangle").width, 2);
  EXPECT_EQ(parse_filter("gaussian").width, 3);
  EXPECT_EQ(parse_filter("mitchell").width, 4);
  EXPECT_EQ(parse_filter("blackman-harris").width, 3);
  EXPECT_EQ(parse_filter("mitchell:2.5").name(), "mitchell:2.5");
  for (const char* bad : {"", "lanczos", "box:", "box:0", "box:-1", "box:nan", "box:inf", "box:101", "box:1px", "Box",
                          "box:1:2", "gaussian:0.001"})
    EXPECT_THROW(static_cast<void>(parse_filter(bad)), UsageError) << bad;
}

TEST(PixelFilter, values_are_the_published_ones) {
  EXPECT_EQ(parse_filter("box:3")(1.4), 1);
  EXPECT_EQ(parse_filter("box:3")(1.6), 0);
  EXPECT_DOUBLE_EQ(parse_filter("triangle")(-0.25), 0.75);
  EXPECT_DOUBLE_EQ(parse_filter("gaussian")(0.5), std::exp(-0.5) - std::exp(-4.5));
  EXPECT_NEAR(parse_filter("gaussian")(1.5), 0, 1e-15);
  const PixelFilter mitchell = parse_filter("mitchell");
  EXPECT_DOUBLE_EQ(mitchell(0), 8.0 / 9);
  EXPECT_NEAR(mitchell(1), 1.0 / 18, 1e-15);
  EXPECT_NEAR(mitchell(8.0 / 7), 0, 1e-15);
  EXPECT_NEAR(mitchell(-1.5), -5.0 / 144, 1e-15);
  EXPECT_NEAR(mitchell(2), 0, 1e-15);
  EXPECT_NEAR(parse_filter("blackman-harris")(0), 1, 1e-12);
  EXPECT_NEAR(parse_filter("blackman-harris")(0.75), 0.35875 - 0.14128, 1e-12);
  EXPECT_NEAR(parse_filter("blackman-harris")(1.5), 6e-5, 1e-12);
}

// From the rim to entry m lies the share (m / bins)^2 of one side.
TEST(PixelFilter, table_is_the_inverse_of_the_distribution) {
  for (const char* name : {"box:2", "triangle", "gaussian", "mitchell", "blackman-harris", "gaussian:7"}) {
    const PixelFilter filter = parse_filter(name);
    const std::vector<float> table = filter_table(filter);
    ASSERT_EQ(table.size(), std::size_t{EK_FILTER_WORDS});
    EXPECT_EQ(table[0], float(filter.width / 2));
    EXPECT_EQ(table[EK_FILTER_BINS], 0);
    // By the trapezoidal rule, in steps that end where entries lie.
    std::vector<double> mass = {0};
    for (std::size_t m = 0; m < EK_FILTER_BINS; ++m) {
      const double outer = double(table[m]), inner = double(table[m + 1]);
      ASSERT_LT(inner, outer) << name << " " << m;
      double sum = 0;
      for (int i = 0; i < 200; ++i) sum += std::abs(filter(outer + (inner - outer) * (i + 0.5) / 200));
      mass.push_back(mass.back() + sum * (outer - inner) / 200);
    }
    for (std::size_t m = 0; m <= EK_FILTER_BINS; ++m)
      ASSERT_NEAR(mass[m] / mass.back(), std::pow(double(m) / EK_FILTER_BINS, 2), 1e-6) << name << " " << m;
  }
}

// Its outer lobes hold 0.034985 of the whole, by integrating (2 - x)^2 (8 - 7 x) / 18.
TEST(PixelFilter, mitchell_s_weight_makes_up_for_its_negative_lobes) {
  const std::vector<float> table = filter_table(parse_filter("mitchell:2"));
  EXPECT_NEAR(table[EK_FILTER_BINS + 1], 4.0 / 7, 1e-7);
  const double lobe = std::pow(6.0 / 7, 3) * 0.5 / 18;
  // The bin in which the sign changes has one density: the factor is right for that, and off the
  // integral by a little.
  EXPECT_NEAR(table[EK_FILTER_BINS + 2], 1 + 4 * lobe, 1e-4);
  EXPECT_EQ(filter_table(parse_filter("gaussian"))[EK_FILTER_BINS + 2], 1);
  EXPECT_GT(filter_table(parse_filter("gaussian"))[EK_FILTER_BINS + 1], 1.5F);
}

}  // namespace
}  // namespace eikon
