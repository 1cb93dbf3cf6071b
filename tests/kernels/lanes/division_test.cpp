// SPDX-License-Identifier: Apache-2.0
// eikon's own division and square root (kernels/lanes/division.h) round correctly, also if the
// driver's first guesses are some units in the last place off.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "kernels/probe.h"

namespace eikon::test {
namespace {

/// A probe whose kernels of one lane divide by eikon's own code.
Probe own_division() {
  return Probe("division").define("EK_OWN_DIVISION", "1").append_file("lanes/division_probes.cl");
}

/// The same, with first guesses that are so many units in the last place off.
Probe with_guesses_off(int units) {
  const auto guess = [&](const std::string& of) {
    return "as_float(as_uint(" + of + ")+(" + std::to_string(units) + "))";
  };
  return own_division()
      .define("EK_GUESS_RECIPROCAL(x)", guess("1.0f/(x)"))
      .define("EK_GUESS_RECIPROCAL_ROOT(x)", guess("1.0f/sqrt(x)"));
}

constexpr std::uint32_t kBlock = 1024;  // numbers that an item of a probe tries

/// Expects a probe to find nothing wrong among the numbers from `begin` to `end`. Kernels of
/// several lanes divide by the driver's operation and always count 0, and those of one lane are
/// expected to have the same words (Probe::run).
void expect_none_wrong(Probe probe, const std::string& name, std::uint32_t begin, std::uint32_t end) {
  Words blocks;
  for (std::uint32_t first = begin; first < end; first += kBlock) blocks.push_back(first);
  (void)probe.compare(blocks.size()).run(name, {blocks}, 1);
}

void expect_all_right(const Probe& probe) {
  expect_none_wrong(probe, "probe_quotients", 0x800000U, 0x1000000U);
  expect_none_wrong(probe, "probe_roots", 0x3f000000U, 0x40000000U);
}

TEST(Division, all_mantissas_of_divisors_and_roots_are_right_with_guesses_up_to_8_units_off) {
  for (const int units : {-8, -4, -2, -1, 0, 1, 2, 4, 8}) {
    SCOPED_TRACE(units);
    expect_all_right(with_guesses_off(units));
  }
}

TEST(Division, all_mantissas_of_divisors_and_roots_are_right_with_the_guesses_of_the_devices) {
  expect_all_right(own_division());
}

bool is_denormal(float x) { return std::fpclassify(x) == FP_SUBNORMAL; }

TEST(Division, numbers_of_all_sizes_divide_as_in_ieee_754) {
  std::mt19937 random(1);
  Words a, b;
  using Limits = std::numeric_limits<float>;
  const float ends[] = {0,           1,       3, Limits::min(), Limits::max(), Limits::infinity(), Limits::quiet_NaN(),
                        1.99999988F, 0x1p-63F};
  for (const float x : ends)
    for (const float y : ends)
      for (const unsigned signs : {0U, 1U, 2U, 3U}) {
        a.push_back(as_word(x) ^ signs << 31);
        b.push_back(as_word(y) ^ signs >> 1 << 31);
      }
  for (int i = 0; i < 60000; ++i) a.push_back(std::uint32_t(random())), b.push_back(std::uint32_t(random()));
  const std::vector<Words> out = own_division().run("probe_division", {a, b}, 2);
  std::size_t finite = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float x = as_float(a[i]), y = as_float(b[i]), quotient = x / y, root = std::sqrt(x);
    const auto same = [](float exact, std::uint32_t word) {
      return std::isnan(exact) ? std::isnan(as_float(word)) : as_word(exact) == word;
    };
    if (is_denormal(x) || is_denormal(y)) continue;
    // The probe leaves out what a device may round as it likes.
    const bool may_be_denormal = std::abs(quotient) < 0x1p-124F && x != 0 && std::isfinite(y);
    if (!may_be_denormal && (std::isfinite(x) || std::abs(y) < 0x1p126F || std::isinf(y))) {
      EXPECT_TRUE(same(quotient, out[0][i])) << x << " / " << y << " is not " << as_float(out[0][i]);
    }
    EXPECT_TRUE(same(root, out[1][i])) << "the root of " << x << " is not " << as_float(out[1][i]);
    finite += std::isnormal(quotient) ? 1 : 0;
  }
  EXPECT_GT(finite, 30000U);
}

}  // namespace
}  // namespace eikon::test
