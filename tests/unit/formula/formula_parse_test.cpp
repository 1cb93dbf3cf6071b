// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "formula/evaluate.h"
#include "formula/kernel_code.h"
#include "formula/parse.h"
#include "support/messages.h"

namespace eikon::formula {
namespace {

using test::contains;

float at(const std::string& text, float x, float y, float z) {
  const Formula f = parse_formula(text);
  return evaluate(f.expressions, f.value, Point{x, y, z, 0, 0, 0});
}

std::string refusal(const std::string& text) {
  return test::error_of([&] { (void)parse_formula(text); });
}

TEST(FormulaParse, operators_bind_as_in_mathematics) {
  EXPECT_EQ(at("x^2+y^2+z^2-1", 1, 2, 3), 13.0F);
  EXPECT_EQ(at("-x^2", 3, 0, 0), -9.0F);
  EXPECT_EQ(at("x^-1", 4, 0, 0), 0.25F);
  EXPECT_EQ(at("x-y-z", 10, 3, 2), 5.0F);
  EXPECT_EQ(at("x/y/z", 12, 3, 2), 2.0F);
  EXPECT_EQ(at("x+2*y^2*z", 1, 3, 2), 37.0F);
  EXPECT_EQ(at("x*2^3^2", 1, 0, 0), 512.0F);
  EXPECT_EQ(at("--x - +y", 3, 5, 0), -2.0F);
  EXPECT_EQ(at(" ( x\t+ y ) * z\n", 1, 2, 3), 9.0F);
  EXPECT_EQ(at("min(x, y, z) + max(x, y)", 5, 2, 3), 7.0F);
  EXPECT_EQ(at("x*1.5e1 + .5 - 2.", 2, 0, 0), 28.5F);
}

TEST(FormulaParse, functions_are_what_they_are_called) {
  EXPECT_FLOAT_EQ(at("sin(x) + 2*cos(y)", 0.3F, 0.4F, 0), std::sin(0.3F) + 2 * std::cos(0.4F));
  EXPECT_FLOAT_EQ(at("tan(x)", 0.7F, 0, 0), std::tan(0.7F));
  EXPECT_FLOAT_EQ(at("exp(x) + log(y)", 1.5F, 2.5F, 0), std::exp(1.5F) + std::log(2.5F));
  EXPECT_FLOAT_EQ(at("atan(x)", -3, 0, 0), std::atan(-3.0F));
  EXPECT_FLOAT_EQ(at("sqrt(x) + abs(y)", 2, -3, 0), std::sqrt(2.0F) + 3);
  EXPECT_FLOAT_EQ(at("sinh(x)", 1.2F, 0, 0), std::sinh(1.2F));
  EXPECT_FLOAT_EQ(at("cosh(x)", 1.2F, 0, 0), std::cosh(1.2F));
  EXPECT_FLOAT_EQ(at("tanh(x)", 1.2F, 0, 0), std::tanh(1.2F));
  EXPECT_FLOAT_EQ(at("x^0.5 + y^(1/3) + x^y", 4, 8, 0), 2.0F + 2.0F + 65536.0F);
  EXPECT_FLOAT_EQ(at("x*pi + e", 2, 0, 0), 2 * std::numbers::pi_v<float> + std::numbers::e_v<float>);
}

TEST(FormulaParse, equal_subexpressions_are_one_and_constants_are_folded) {
  const Formula f = parse_formula("(x+y)*(y+x) + sin(x+y) - (2*3-6)*z");
  std::size_t sums = 0;
  for (Id id = 0; id < f.expressions.size(); ++id) {
    const Node& node = f.expressions[id];
    const Node& first = f.expressions[node.operands[0]];
    sums += node.op == Op::add && first.op == Op::variable && first.number < 3 ? 1U : 0U;
  }
  EXPECT_EQ(sums, 1U);
  EXPECT_TRUE(f.expressions.is_constant(f.gradient[2], 0.0F));
}

TEST(FormulaParse, the_derivatives_are_those_of_differences) {
  const std::vector<std::string> formulas = {"x^2*y - y/z + z^3",
                                             "sin(x*y) + cos(z)^2",
                                             "exp(x/2)*log(y+3) - atan(z)",
                                             "sqrt(x+2)*tan(y/2) + z",
                                             "min(x*y, z) + abs(x-y)",
                                             "max(x, y*z)^2 - 1/(x+3)",
                                             "tanh(x)*sinh(y)*cosh(z)",
                                             "(x^2+y^2+z^2+3)^2-16*(x^2+y^2)",
                                             "(x+3)^(y+2)^1.5",
                                             "-(x-y)*-(z-x)"};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const std::string& text : formulas) {
    const Formula f = parse_formula(text);
    for (int i = 0; i < 100; ++i) {
      std::array<double, kVariables> p{};
      for (double& value : p) value = uniform(random);
      std::array<double, 3> gradient{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double h = 1e-5;
        auto low = p, high = p;
        low[axis] -= h;
        high[axis] += h;
        const double difference =
            (evaluate_double(f.expressions, f.value, high) - evaluate_double(f.expressions, f.value, low)) / (2 * h);
        gradient[axis] = evaluate_double(f.expressions, f.gradient[axis], p);
        EXPECT_NEAR(gradient[axis], difference, 1e-6 * (1 + std::abs(difference))) << text << " axis " << axis;
      }
      const double along = gradient[0] * p[3] + gradient[1] * p[4] + gradient[2] * p[5];
      EXPECT_NEAR(evaluate_double(f.expressions, f.slope, p), along, 1e-9 * (1 + std::abs(along))) << text;
    }
  }
}

TEST(FormulaParse, what_does_not_parse_is_refused_with_its_column) {
  EXPECT_EQ(refusal("x^2 + foo(y)"),
            "column 7: unknown name 'foo'; known: x y z pi e sqrt abs min max sin cos tan exp log atan sinh cosh tanh");
  EXPECT_EQ(refusal("2x"), "column 2: expected an operator before 'x'");
  EXPECT_EQ(refusal("x+"), "column 3: expected a number, a name or '(', not the end");
  EXPECT_EQ(refusal("x \u00b2"), "column 3: expected an operator before '\u00b2'");
  EXPECT_EQ(refusal("\u6f22"), "column 1: expected a number, a name or '(', not '\u6f22'");
  EXPECT_EQ(refusal(""), "column 1: expected a number, a name or '(', not the end");
  EXPECT_EQ(refusal("(x+y"), "column 5: expected ')' for the '(' of column 1, not the end");
  EXPECT_EQ(refusal("x)"), "column 2: expected an operator before ')'");
  EXPECT_EQ(refusal("sin x"), "column 5: expected '(' after sin, not 'x'");
  EXPECT_EQ(refusal("sin(x, y)"), "column 9: sin takes one value, not 2");
  EXPECT_EQ(refusal("min(x)"), "column 1: min takes two values or more");
  EXPECT_EQ(refusal("max(x; y)"), "column 6: expected ',' or ')' in the values of max, not ';'");
  EXPECT_EQ(refusal("x/0"), "column 3: division by zero");
  EXPECT_EQ(refusal("x + 1e39"), "column 5: the number is out of a float's range");
  EXPECT_EQ(refusal("x + ."), "column 5: a number needs digits");
  EXPECT_EQ(refusal("0^(x+2)"), "column 3: a power of a constant that is not positive needs a constant exponent");
  EXPECT_EQ(refusal("1 + (0-1)^x"), "column 11: a power of a constant that is not positive needs a constant exponent");
  EXPECT_EQ(refusal("(1e30*x)*1e30"), "its derivative has a constant beyond a float's range; use smaller constants");
  EXPECT_EQ(refusal("2^x + 0^0.5 - 1"), "");
  EXPECT_EQ(refusal("x*log(0-1)"), "column 3: this constant has no finite value");
  EXPECT_EQ(refusal("x + 1e30*1e30"), "column 9: this constant has no finite value");
  EXPECT_EQ(refusal("3 + pi"), "does not depend on x, y or z, so it is no surface");
  EXPECT_EQ(refusal("x - x*0 - x"), "");
  EXPECT_EQ(refusal(std::string("x\0y", 3)), "column 2: expected an operator before '\\x00'");
  EXPECT_EQ(refusal(std::string(4097, 'x')), "too long: 4097 characters; at most 4096");
  EXPECT_EQ(refusal(std::string(63, '(') + "x" + std::string(63, ')')), "");
  EXPECT_EQ(refusal(std::string(64, '(') + "x" + std::string(64, ')')), "column 65: nested more than 64 deep");
  EXPECT_TRUE(contains(refusal([] {
                         std::string text = "x";
                         for (int i = 0; i < 300; ++i) text += fmt::format("*sin({}*x+y)", i + 2);
                         return text.substr(0, kMaxCharacters).substr(0, text.rfind("*sin"));
                       }()),
                       "too complex"));
}

TEST(FormulaParse, no_text_crashes_it_and_what_it_accepts_has_kernel_code_and_values) {
  const std::vector<std::string> seeds = {"x^2+y^2+z^2-1",
                                          "(x^2+y^2+z^2+3)^2-16*(x^2+y^2)",
                                          "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
                                          "exp(-(x^2+y^2))+exp(-((x-1)^2+z^2))-0.5",
                                          "min(max(x,y),z)-abs(x*y)/sqrt(z^2+1)",
                                          "tan(x)-log(y+2)^-3*atan(z)*pi",
                                          "1.5e-3*x^.5 - --y^(1/3)"};
  const std::string alphabet = std::string("xyz0123456789.+-*/^(),e \t\n\xff_#;=abcdefghijklmnopqrstuvw") + '\0';
  std::mt19937 random(20);
  const auto below = [&](std::size_t n) { return std::size_t(random() % n); };
  std::size_t accepted = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string text = seeds[below(seeds.size())];
    for (std::size_t k = below(6); k-- > 0;) {
      const std::size_t place = below(text.size() + 1);
      const std::string& other = seeds[below(seeds.size())];
      switch (below(5)) {
        case 0:
          text.insert(place, 1, alphabet[below(alphabet.size())]);
          break;
        case 1:
          text.erase(place, 1 + below(4));
          break;
        case 2:
          if (place < text.size()) text[place] = alphabet[below(alphabet.size())];
          break;
        case 3:
          text.insert(place, other.substr(below(other.size()), below(8)));
          break;
        default:
          text += text.substr(place);
          break;
      }
    }
    try {
      const Formula f = parse_formula(text);
      ++accepted;
      const Region region{{{-1, 2}, {0, 1}, {-3, 0.5F}, {1, 1}, {0.5F, 0.5F}, {-1, -1}}};
      const RegionValue bounds = evaluate(f.expressions, f.slope, region);
      EXPECT_LE(bounds.bounds.lo, bounds.bounds.hi) << text;
      if (i % 16 == 0) {
        EXPECT_GT(kernel_code({f}).size(), 100U);
      }
    } catch (const InputError& error) {
      EXPECT_FALSE(contains(error.what(), "\n")) << text;
    }
  }
  EXPECT_GT(accepted, 20000U);
  EXPECT_LT(accepted, 80000U);
}

TEST(FormulaParse, kernel_code_divides_and_takes_roots_as_all_kernels_do) {
  const std::string code = kernel_code({parse_formula("x/y+sqrt(z)")});
  EXPECT_TRUE(contains(code, "div_f("));
  EXPECT_TRUE(contains(code, "sqrt_f("));
  EXPECT_FALSE(contains(code, " / "));
  EXPECT_FALSE(contains(code, " sqrt("));
}

}  // namespace
}  // namespace eikon::formula
