// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/plot.h"

namespace eikon {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Plot, decades_enclose_the_values) {
  const auto expect = [](const std::vector<double>& values, int first, int last) {
    const Decades decades = enclosing_decades(values);
    EXPECT_EQ(decades.first, first);
    EXPECT_EQ(decades.last, last);
  };
  expect({0.02, 3, 40}, -2, 2);
  expect({5e-7, 2e-6}, -7, -5);
  expect({1, 100}, 0, 2);  // powers of ten enclose themselves
  expect({10}, 1, 2);      // at least a decade
  expect({0.3, 0.4}, -1, 0);
  expect({}, 0, 1);
}

TEST(Plot, a_point_lies_where_its_logarithms_say) {
  // One decade each way, 70 to 440 across and 310 to 50 up: half way in the logarithm is sqrt(10).
  const std::string svg =
      log_log_svg("t", {{"x", "y", {{"s", {{1, 1}, {std::sqrt(10.0), std::sqrt(10.0)}, {10, 10}}}}}});
  EXPECT_TRUE(contains(svg, "d=\"M70.0 310.0L255.0 180.0L440.0 50.0\"")) << svg;
  EXPECT_TRUE(contains(svg, "<circle cx=\"255.0\" cy=\"180.0\""));
}

TEST(Plot, points_without_a_logarithm_are_left_out) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::string svg =
      log_log_svg("t", {{"x", "y", {{"s", {{1, 1}, {0, 1}, {1, -1}, {nan, 1}, {1, inf}, {10, 10}}}}}});
  EXPECT_TRUE(contains(svg, "d=\"M70.0 310.0L440.0 50.0\"")) << svg;
  EXPECT_FALSE(contains(svg, "nan"));
  EXPECT_FALSE(contains(svg, "inf"));
}

TEST(Plot, no_points_give_a_picture_too_and_any_text_is_safe) {
  const std::string svg = log_log_svg("<a & b>\n\xff", {{"x", "y", {{"none", {}}}}});
  EXPECT_TRUE(contains(svg, "&lt;a &amp; b&gt;??")) << svg;
  EXPECT_FALSE(contains(svg, "<circle"));
  EXPECT_TRUE(contains(svg, "</svg>"));
}

}  // namespace
}  // namespace eikon
