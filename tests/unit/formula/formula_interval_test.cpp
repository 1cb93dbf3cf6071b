// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "formula/evaluate.h"
#include "formula/parse.h"

namespace eikon::formula {
namespace {

struct Random {
  std::mt19937 words{7};
  float uniform(float lo, float hi) { return lo + (hi - lo) * (float(words() >> 8) * 0x1p-24F); }
  // Any sign, any magnitude within 2^-span .. 2^span.
  float wide(int span) {
    const float magnitude = std::ldexp(1.0F + float(words() >> 9) * 0x1p-23F, int(words() % unsigned(2 * span)) - span);
    return (words() & 1U) != 0 ? magnitude : -magnitude;
  }
};

Bounds1 around(Random& random, float middle) {
  if (random.words() % 4 == 0) return {middle, middle};
  const float width =
      std::abs(middle) * std::ldexp(1.0F, -int(random.words() % 26)) + (random.words() % 8 == 0 ? 1.0F : 0.0F);
  return {middle - width * random.uniform(0, 1), middle + width * random.uniform(0, 1)};
}

float inside(Random& random, Bounds1 b) {
  switch (random.words() % 4) {
    case 0:
      return b.lo;
    case 1:
      return b.hi;
    default:
      return std::min(std::max(random.uniform(b.lo, b.hi), b.lo), b.hi);
  }
}

// Numbers that are not: NaN has no place; an infinite float stands for a number that no float
// holds.
template <class Number>
::testing::AssertionResult encloses(const RegionValue& value, Number number) {
  if (std::isnan(number)) return ::testing::AssertionSuccess();
  const bool above = !(double(value.bounds.lo) > double(number)), below = !(double(value.bounds.hi) < double(number));
  if (!value.undefined && above && below) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << double(number) << " is outside [" << value.bounds.lo << ", "
                                       << value.bounds.hi << "]" << (value.undefined ? ", which has no value" : "");
}

// Each operation by itself, over all magnitudes, and formulas whole, over a box.
TEST(FormulaInterval, a_million_boxes_enclose_their_exact_values_and_those_in_floats) {
  const std::vector<std::string> formulas = {"x+y",      "x-y",    "x*y",    "x/y",     "x^2+0*y", "x^3+y*0",
                                             "x^4",      "x^7",    "x^-2",   "sqrt(x)", "abs(x)",  "min(x,y)",
                                             "max(x,y)", "sin(x)", "cos(x)", "exp(x)",  "log(x)",  "atan(x)",
                                             "x^64",     "2.5*x",  "-x",     "tan(x)",  "x^y"};
  Random random;
  for (const std::string& text : formulas) {
    const Formula f = parse_formula(text);
    const bool angle = text.find('(') != std::string::npos;
    for (int i = 0; i < 30000; ++i) {
      const int span = angle ? 17 : 62;
      Region region{};
      for (std::size_t k = 0; k < 3; ++k) region[k] = around(random, random.wide(span));
      for (std::size_t k = 3; k < 6; ++k) region[k] = around(random, random.uniform(-2, 2));
      const RegionValue value = evaluate(f.expressions, f.value, region),
                        slope = evaluate(f.expressions, f.slope, region);
      for (int j = 0; j < 4; ++j) {
        Point point{};
        std::array<double, kVariables> exact{};
        for (std::size_t k = 0; k < kVariables; ++k) exact[k] = double(point[k] = inside(random, region[k]));
        ASSERT_TRUE(encloses(value, evaluate(f.expressions, f.value, point)))
            << text << " in floats, x " << point[0] << " y " << point[1];
        ASSERT_TRUE(encloses(value, evaluate_double(f.expressions, f.value, exact)))
            << text << ", x " << point[0] << " y " << point[1];
        ASSERT_TRUE(encloses(slope, evaluate(f.expressions, f.slope, point)))
            << text << "'s slope in floats, x " << point[0] << " y " << point[1];
        ASSERT_TRUE(encloses(slope, evaluate_double(f.expressions, f.slope, exact)))
            << text << "'s slope, x " << point[0] << " y " << point[1];
      }
    }
  }
}

TEST(FormulaInterval, formulas_of_surfaces_are_enclosed_with_their_slopes) {
  const std::vector<std::string> formulas = {"x^2+y^2+z^2-1",
                                             "(x^2+y^2+z^2+3)^2-16*(x^2+y^2)",
                                             "(x^2+9/4*y^2+z^2-1)^3-x^2*z^3-9/80*y^2*z^3",
                                             "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
                                             "1/(x^2+y^2+z^2)+1/((x-1)^2+y^2+z^2)-8",
                                             "exp(-(x^2+y^2))*log(z+4)-sqrt(abs(x*y)+1)+max(x,min(y,z))"};
  Random random;
  for (const std::string& text : formulas) {
    const Formula f = parse_formula(text);
    for (int i = 0; i < 60000; ++i) {
      Region region{};
      for (std::size_t k = 0; k < kVariables; ++k) region[k] = around(random, random.uniform(-3, 3));
      Point point{};
      std::array<double, kVariables> exact{};
      for (std::size_t k = 0; k < kVariables; ++k) exact[k] = double(point[k] = inside(random, region[k]));
      const RegionValue value = evaluate(f.expressions, f.value, region),
                        slope = evaluate(f.expressions, f.slope, region);
      ASSERT_TRUE(encloses(value, evaluate(f.expressions, f.value, point))) << text;
      ASSERT_TRUE(encloses(value, evaluate_double(f.expressions, f.value, exact))) << text;
      ASSERT_TRUE(encloses(slope, evaluate(f.expressions, f.slope, point))) << text;
      ASSERT_TRUE(encloses(slope, evaluate_double(f.expressions, f.slope, exact))) << text;
    }
  }
}

// Sound alone is no use: [-inf, inf] is sound. The slopes of these formulas add up to at most 122
// in the boxes drawn.
TEST(FormulaInterval, narrow_boxes_have_narrow_values) {
  const std::vector<std::string> formulas = {"x^2+y^2+z^2-1", "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
                                             "exp(x)/y+log(z)", "sqrt(x)+atan(y)-abs(z)+x^3"};
  Random random;
  for (const std::string& text : formulas) {
    const Formula f = parse_formula(text);
    for (int i = 0; i < 1000; ++i) {
      Region region{};
      for (std::size_t k = 0; k < kVariables; ++k) {
        const float at = random.uniform(0.5F, 3);
        region[k] = {at, at + 0x1p-12F};
      }
      const RegionValue value = evaluate(f.expressions, f.value, region);
      ASSERT_LE(value.bounds.hi - value.bounds.lo, 130 * 0x1p-12F) << text;
      for (std::size_t k = 0; k < kVariables; ++k) region[k].hi = region[k].lo;
      const RegionValue point = evaluate(f.expressions, f.value, region);
      ASSERT_LE(point.bounds.hi - point.bounds.lo, 60 * 0x1p-20F) << text;
    }
  }
}

TEST(FormulaInterval, what_has_no_value_says_so_and_what_reaches_infinity_stays_unbounded) {
  const auto of = [](const char* text, Bounds1 x) {
    const Formula f = parse_formula(text);
    return evaluate(f.expressions, f.value, Region{{x, {1, 1}, {1, 1}, {1, 1}, {0, 0}, {0, 0}}});
  };
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(of("sqrt(x)", {-2, -1}).undefined);
  EXPECT_TRUE(of("log(x)", {-2, -1}).undefined);
  EXPECT_FALSE(of("sqrt(x)", {-2, 1}).undefined);
  EXPECT_EQ(of("sqrt(x)", {-2, 1}).bounds.lo, 0.0F);
  EXPECT_EQ(of("log(x)", {0, 1}).bounds.lo, -infinity);
  EXPECT_EQ(of("1/x", {-1, 1}).bounds.hi, infinity);
  EXPECT_EQ(of("1/x", {0, 1}).bounds.lo, -infinity);
  EXPECT_EQ(of("sin(x)", {0, 200000}).bounds.hi, infinity);
  EXPECT_EQ(of("0.5*exp(x)", {0, 100}).bounds.hi, infinity);
  EXPECT_EQ(of("exp(x)*1e-30", {100, 101}).bounds.hi, infinity);
  EXPECT_EQ(of("(1/x)^2", {-1, 1}).bounds.hi, infinity);
  EXPECT_EQ(of("x^2", {-1, 3}).bounds.lo, 0.0F);
  EXPECT_EQ(of("sin(x)", {0, 7}).bounds.lo, -1.0F);
  EXPECT_EQ(of("sin(x)", {1, 2}).bounds.hi, 1.0F);
  EXPECT_LT(of("sin(x)", {1.6F, 2}).bounds.hi, 1.0F);
}

double relative_error(float value, double exact) { return std::abs(double(value) - exact) / std::abs(exact); }

// The bounds that interval.h takes for granted.
TEST(FormulaInterval, the_functions_are_as_exact_as_the_intervals_believe) {
  const auto make = [](const char* text) { return parse_formula(text); };
  const Formula sine = make("sin(x)"), cosine = make("cos(x)"), exponential = make("exp(x)"),
                logarithm = make("log(x)"), arc = make("atan(x)");
  const auto of = [](const Formula& f, float x) { return evaluate(f.expressions, f.value, Point{x, 0, 0, 0, 0, 0}); };
  Random random;
  double angle = 0, power = 0, log = 0, atan = 0;
  for (int i = 0; i < 400000; ++i) {
    const float x = i % 2 == 0 ? random.uniform(-8, 8) : random.uniform(-102000, 102000);
    angle = std::max(angle, std::abs(double(of(sine, x)) - std::sin(double(x))));
    angle = std::max(angle, std::abs(double(of(cosine, x)) - std::cos(double(x))));
    const float e = random.uniform(-87, 88.72F);
    power = std::max(power, relative_error(of(exponential, e), std::exp(double(e))));
    const float l = i % 2 == 0 ? random.uniform(0.5F, 2) : std::abs(random.wide(120));
    if (l != 1) log = std::max(log, relative_error(of(logarithm, l), std::log(double(l))));
    const float a = random.wide(30);
    atan = std::max(atan, relative_error(of(arc, a), std::atan(double(a))));
  }
  EXPECT_LE(angle, 0x1p-23);
  EXPECT_LE(power, 0x1p-22);
  EXPECT_LE(log, 0x1p-22);
  EXPECT_LE(atan, 0x1p-21);
  EXPECT_EQ(of(logarithm, 1), 0.0F);
  EXPECT_EQ(of(exponential, 0), 1.0F);
  EXPECT_EQ(of(exponential, -88), 0.0F);
  EXPECT_TRUE(std::isinf(of(exponential, 89)));
  EXPECT_TRUE(std::isnan(of(sine, 200000)));
  EXPECT_TRUE(std::isnan(of(logarithm, -1)));
}

}  // namespace
}  // namespace eikon::formula
