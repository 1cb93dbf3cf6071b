// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "kernels/probe.h"

namespace eikon::test {
namespace {

// Distance in units of the last place of a float near `exact`.
double ulp_error(float x, double exact) {
  const int exponent = exact == 0 ? -126 : std::max(std::ilogb(exact), -126);
  return std::abs(double(x) - exact) / std::ldexp(1.0, exponent - 23);
}

struct SincosError {
  double sin_ulp = 0, cos_ulp = 0, absolute = 0;
};

SincosError sincos_error(const Words& turns) {
  const auto out = Probe("math").run("probe_sincos_2pi", {turns}, 2);
  SincosError worst;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const double u = as_float(turns[i]);
    // The nearest quarter is taken off exactly, so that double's own sin and cos see small
    // arguments.
    const double quarters = std::nearbyint(4 * u);
    const double angle = 2 * std::numbers::pi * (u - quarters / 4);
    const int quadrant = int(std::fmod(quarters, 4.0)) & 3;
    const double sines[] = {std::sin(angle), std::cos(angle), -std::sin(angle), -std::cos(angle)};
    const double s = sines[quadrant], c = sines[(quadrant + 1) & 3];
    worst.sin_ulp = std::max(worst.sin_ulp, ulp_error(as_float(out[0][i]), s));
    worst.cos_ulp = std::max(worst.cos_ulp, ulp_error(as_float(out[1][i]), c));
    worst.absolute = std::max({worst.absolute, std::abs(as_float(out[0][i]) - s), std::abs(as_float(out[1][i]) - c)});
  }
  return worst;
}

TEST(Math, sincos_2pi_is_within_1_6_ulp_over_the_unit_interval) {
  Words turns;
  for (std::uint32_t k = 0; k < (1U << 22); ++k) turns.push_back(as_word(float(k) * 0x1p-22F));
  for (std::uint32_t word = 0x20000000U; word < 0x3f800000U; word += 1237) turns.push_back(word);  // small ones, too
  const SincosError worst = sincos_error(turns);
  EXPECT_LE(worst.sin_ulp, 1.6);
  EXPECT_LE(worst.cos_ulp, 1.6);
  EXPECT_LE(worst.absolute, 1e-7);
}

TEST(Math, sincos_2pi_is_within_1_6_ulp_up_to_a_million_turns_either_way) {
  std::mt19937 random(1);
  Words turns;
  for (int i = 0; i < 1 << 19; ++i) {
    const float magnitude = std::ldexp(float(random() >> 8) * 0x1p-24F + 1.0F, int(random() % 44) - 24);
    turns.push_back(as_word((random() & 1U) != 0 ? magnitude : -magnitude));
  }
  const SincosError worst = sincos_error(turns);
  EXPECT_LE(worst.sin_ulp, 1.6);
  EXPECT_LE(worst.cos_ulp, 1.6);
  EXPECT_LE(worst.absolute, 1e-7);
}

TEST(Math, sincos_2pi_is_exact_at_quarter_turns) {
  const auto out = Probe("math").run("probe_sincos_2pi", {as_words({0, 0.25F, 0.5F, 0.75F, 1, -0.25F, 1000.5F})}, 2);
  const float s[] = {0, 1, 0, -1, 0, -1, 0}, c[] = {1, 0, -1, 0, 1, 0, -1};
  for (std::size_t i = 0; i < std::size(s); ++i) {
    EXPECT_EQ(as_float(out[0][i]), s[i]) << i;
    EXPECT_EQ(as_float(out[1][i]), c[i]) << i;
  }
}

TEST(Math, exp2_is_within_1_3_ulp_and_flushes_what_would_be_denormal) {
  std::mt19937 random(3);
  Words x = as_words({0, -0.0F, 1, -1, 0.5F, -0.5F, 127.99999F, -125.99999F, -126, 64.5F, -64.5F, 1e-30F, -1e-30F});
  for (int i = 0; i < 1 << 19; ++i) x.push_back(as_word(254 * (float(random() >> 8) * 0x1p-24F) - 126));
  for (int i = 0; i < 1 << 19; ++i) x.push_back(as_word(2 * (float(random() >> 8) * 0x1p-24F) - 1));
  const Words out = Probe("math").run("probe_exp2", {x}, 1)[0];
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    worst = std::max(worst, ulp_error(as_float(out[i]), std::exp2(double(as_float(x[i])))));
  EXPECT_LE(worst, 1.3);
  Words whole;
  for (int k = -126; k <= 127; ++k) whole.push_back(as_word(float(k)));
  const Words powers = Probe("math").run("probe_exp2", {whole}, 1)[0];
  for (int k = -126; k <= 127; ++k) ASSERT_EQ(as_float(powers[std::size_t(k + 126)]), std::ldexp(1.0F, k)) << k;
}

TEST(Math, exp2_beyond_the_range_is_0_or_infinite) {
  const float inf = INFINITY;
  const Words below = as_words({-126.00001F, -127, -150, -1e10F, -3e38F, -inf}),
              above = as_words({128, 129, 1e10F, inf});
  EXPECT_EQ(Probe("math").run("probe_exp2", {below}, 1)[0], Words(below.size(), as_word(0.0F)));
  EXPECT_EQ(Probe("math").run("probe_exp2", {above}, 1)[0], Words(above.size(), as_word(inf)));
}

TEST(Math, log2_is_within_3_ulp_next_to_1_too) {
  std::mt19937 random(4);
  Words x = as_words({1, 2, 0.5F, 0x1p-126F, 0x1.fffffep+127F, 0x1.fffffep-1F, 0x1.000002p+0F, 1.41421354F, 1.41421366F});
  for (int i = 0; i < 1 << 19; ++i) x.push_back(0x00800000U + std::uint32_t(random()) % 0x7f000000U);
  for (int i = 0; i < 1 << 19; ++i) x.push_back(as_word(0.5F + 1.5F * (float(random() >> 8) * 0x1p-24F)));
  const Words out = Probe("math").run("probe_log2", {x}, 1)[0];
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    worst = std::max(worst, ulp_error(as_float(out[i]), std::log2(double(as_float(x[i])))));
  EXPECT_LE(worst, 3);
  for (const float nothing : {0.0F, -0.0F, 1e-40F, -1.0F})
    EXPECT_EQ(as_float(Probe("math").run("probe_log2", {as_words({nothing})}, 1)[0][0]), -126) << nothing;
}

double atan2_turns_error(const Words& y, const Words& x) {
  const Words out = Probe("math").run("probe_atan2_turns", {y, x}, 1)[0];
  double worst = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double exact = std::atan2(double(as_float(y[i])), double(as_float(x[i]))) / (2 * std::numbers::pi);
    const double error = ulp_error(as_float(out[i]), exact);
    if (!(error <= worst)) worst = error;  // NaN too
  }
  return worst;
}

TEST(Math, atan2_turns_is_within_2_2_ulp_all_around_and_at_any_ratio) {
  std::mt19937 random(3);
  Words y, x;
  for (int i = 0; i < 1 << 20; ++i) {
    const double angle = 2 * std::numbers::pi * double(random()) / 4294967296.0;
    y.push_back(as_word(float(std::sin(angle))));
    x.push_back(as_word(float(std::cos(angle))));
  }
  for (int i = 0; i < 1 << 20; ++i)
    for (Words* words : {&y, &x}) {
      const float magnitude = std::ldexp(float(random() >> 8) * 0x1p-24F + 1.0F, int(random() % 80) - 40);
      words->push_back(as_word((random() & 1U) != 0 ? magnitude : -magnitude));
    }
  EXPECT_LE(atan2_turns_error(y, x), 2.2);
}

TEST(Math, atan2_turns_is_exact_on_axes_and_diagonals_and_0_at_the_origin) {
  const float d = 1e-40F;  // denormal
  const std::vector<float> y{0, -0.0F, 1, -1, 0, -0.0F, 3, 3, -3, -3, 0, -0.0F, 0, d, -d, 1},
      x{1, 2, 0, -0.0F, -1, -5, 3, -3, 3, -3, 0, 0, -0.0F, d, -d, 1e-30F};
  const float expected[] = {0,       -0.0F,   0.25F, -0.25F, 0.5F, -0.5F, 0.125F, 0.375F,
                            -0.125F, -0.375F, 0,     -0.0F,  0,    0,     -0.0F,  0.25F};
  const Words out = Probe("math").run("probe_atan2_turns", {as_words(y), as_words(x)}, 1)[0];
  for (std::size_t i = 0; i < y.size(); ++i) EXPECT_EQ(out[i], as_word(expected[i])) << y[i] << ", " << x[i];
}

// The host is compiled without contraction, so it has the bits that the text of math.h promises.
TEST(Math, vector_functions_round_as_written) {
  std::mt19937 random(2);
  std::vector<Words> in(6);
  for (int i = 0; i < 1 << 16; ++i)
    for (auto& words : in) {
      const float magnitude = std::ldexp(float(random() >> 8) * 0x1p-24F + 1.0F, int(random() % 40) - 20);
      words.push_back(as_word((random() & 1U) != 0 ? magnitude : -magnitude));
    }
  const auto out = Probe("math").run("probe_vectors", in, 30);
  for (std::size_t i = 0; i < in[0].size(); ++i) {
    float a[3], b[3];
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = as_float(in[k][i]);
      b[k] = as_float(in[3 + k][i]);
    }
    const float length = std::sqrt((a[0] * a[0] + a[1] * a[1]) + a[2] * a[2]);
    const float inverse = 1.0F / length;
    const float expected[30] = {a[0] + b[0],
                                a[1] + b[1],
                                a[2] + b[2],
                                a[0] - b[0],
                                a[1] - b[1],
                                a[2] - b[2],
                                a[0] * b[0],
                                a[1] * b[1],
                                a[2] * b[2],
                                a[0] * b[0],
                                a[1] * b[0],
                                a[2] * b[0],
                                (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2],
                                a[1] * b[2] - a[2] * b[1],
                                a[2] * b[0] - a[0] * b[2],
                                a[0] * b[1] - a[1] * b[0],
                                a[0] * inverse,
                                a[1] * inverse,
                                a[2] * inverse,
                                a[0] < b[0] ? a[0] : -b[0],
                                a[0] < b[0] ? a[1] : -b[1],
                                a[0] < b[0] ? a[2] : -b[2],
                                std::min(a[0], b[0]),
                                std::max(a[0], b[0]),
                                std::abs(a[1]),
                                std::copysign(a[2], b[2]),
                                std::max({a[0], a[1], a[2]}),
                                as_float(1U),
                                a[0] / b[1],
                                std::sqrt(std::abs(a[2]))};
    for (std::size_t k = 0; k < 30; ++k)
      ASSERT_EQ(out[k][i], as_word(expected[k])) << "output " << k << " of item " << i;
  }
}

TEST(Math, finite_means_neither_infinite_nor_nan) {
  const Words one = as_words({1, -3e38F, 0, 1, -1, 0}), by = as_words({1, 1, 5, 0, 0, 0});
  const auto out = Probe("math").run("probe_vectors", {one, one, one, by, one, one}, 30);
  EXPECT_EQ(out[27], (Words{1, 1, 1, 0, 0, 0}));
}

}  // namespace
}  // namespace eikon::test
