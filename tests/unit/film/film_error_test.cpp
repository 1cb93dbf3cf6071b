// SPDX-License-Identifier: Apache-2.0
// The predicted relMSE against synthetic pixels whose true error is known in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "support/film_builder.h"
#include "support/fixed_point.h"

namespace eikon {
namespace {

using test::small_layout;

constexpr double kEpsilon = 1e-2;

struct PixelModel {
  double mean = 0, variance = 0;  // of one sample
  std::function<double(std::mt19937_64&)> draw;
};
using Model = std::function<PixelModel(std::uint32_t x, std::uint32_t y)>;

/// Expectation of what `compare` finds when every replicate has `samples` samples.
double true_relmse(const Model& model, std::uint32_t side, std::uint32_t replicates, int samples) {
  double sum = 0;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const PixelModel pixel = model(x, y);
      sum += pixel.variance / (replicates * static_cast<double>(samples)) / (pixel.mean * pixel.mean + kEpsilon);
    }
  return sum / (side * side);
}

/// The channels share the sample, as they nearly do in a render: the pixel is what is independent.
Film draw_film(const Model& model, std::uint32_t side, std::uint32_t replicates, int samples, std::mt19937_64& random) {
  Film film(small_layout(side, side, replicates));
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const PixelModel pixel = model(x, y);
      for (std::uint32_t r = 0; r < replicates; ++r) {
        int128 sum = 0;
        for (int i = 0; i < samples; ++i) sum += to_fixed(static_cast<float>(pixel.draw(random)));
        for (std::uint32_t c = 0; c < 3; ++c) film.set(x, y, r, c, sum);
        film.set_count(x, y, r, static_cast<std::uint64_t>(samples));
      }
    }
  return film;
}

struct Coverage {
  double covered = 0;     // share of 200 runs whose interval holds the truth
  double both_ends = 0;   // share of those whose interval has an upper end
  double mean_ratio = 0;  // mean prediction over the truth
  double width = 0;       // mean of half of the logarithm of the upper over the lower end
};

Coverage measure(const Model& model, std::uint32_t side, std::uint32_t replicates, int samples, unsigned seed) {
  constexpr int kRuns = 200;
  std::mt19937_64 random(seed);
  const double truth = true_relmse(model, side, replicates, samples);
  Coverage result;
  for (int run = 0; run < kRuns; ++run) {
    const PredictedError error = draw_film(model, side, replicates, samples, random).predicted_error();
    EXPECT_TRUE(error.known);
    result.covered += (error.lo <= truth && truth <= error.hi ? 1.0 : 0.0) / kRuns;
    result.both_ends += (std::isfinite(error.hi) ? 1.0 : 0.0) / kRuns;
    result.mean_ratio += error.relmse / truth / kRuns;
    result.width += std::log(error.hi / error.lo) / 2 / kRuns;
  }
  return result;
}

PixelModel normal(double mean, double deviation) {
  return {mean, deviation * deviation,
          [=](std::mt19937_64& random) { return std::normal_distribution<double>(mean, deviation)(random); }};
}

/// Like light that arrives by few of the samples: log-normal, so variance and skewness grow
/// together with sigma.
PixelModel log_normal(double mean, double sigma) {
  const double mu = std::log(mean) - sigma * sigma / 2;
  return {mean, mean * mean * std::expm1(sigma * sigma),
          [=](std::mt19937_64& random) { return std::lognormal_distribution<double>(mu, sigma)(random); }};
}

double gradient(std::uint32_t x, std::uint32_t y) { return 0.02 + 0.05 * x + 0.01 * y; }
double checkers(std::uint32_t x, std::uint32_t y) { return (x / 4 + y / 4) % 2 == 0 ? 0.05 : 1.0; }
/// No pixel says anything of its neighbour.
double unrelated(std::uint32_t x, std::uint32_t y) {
  std::mt19937 random(x * 977 + y);
  random.discard(3);
  return std::exp(std::normal_distribution<double>(-1, 1)(random));
}

TEST(PredictedError, N15_the_interval_covers_the_truth_on_a_gradient) {
  const Coverage c = measure([](auto x, auto y) { return normal(gradient(x, y), gradient(x, y)); }, 24, 2, 8, 1);
  EXPECT_NEAR(c.covered, 0.95, 0.04);
  EXPECT_NEAR(c.mean_ratio, 1, 0.06);
}

TEST(PredictedError, N15_the_interval_covers_the_truth_at_edges_with_skewed_samples) {
  const Coverage c = measure([](auto x, auto y) { return log_normal(checkers(x, y), 1); }, 24, 2, 16, 2);
  EXPECT_NEAR(c.covered, 0.95, 0.04);
  EXPECT_NEAR(c.mean_ratio, 1, 0.06);
}

TEST(PredictedError, N15_the_interval_covers_the_truth_with_eight_replicates) {
  const Coverage c = measure([](auto x, auto y) { return log_normal(gradient(x, y), 0.7); }, 24, 8, 4, 4);
  EXPECT_NEAR(c.covered, 0.95, 0.04);
  EXPECT_NEAR(c.mean_ratio, 1, 0.06);
}

TEST(PredictedError, is_within_15_percent_when_pixels_have_nothing_to_do_with_their_neighbours) {
  const Coverage c =
      measure([](auto x, auto y) { return normal(unrelated(x, y), 0.5 * unrelated(x, y)); }, 24, 2, 8, 3);
  EXPECT_NEAR(c.mean_ratio, 1, 0.15);
}

// Samples with a standard deviation of 2.9 and 7.3 times their mean: the interval covers 90 and 72
// %, because some runs have not met the outliers that carry the error. The prediction on average is
// right to 4 and 16 %.
TEST(PredictedError, heavy_tails_cost_coverage_but_little_bias) {
  const Coverage skewed = measure([](auto x, auto y) { return log_normal(gradient(x, y), 1.5); }, 24, 2, 16, 5);
  EXPECT_GT(skewed.covered, 0.78);
  EXPECT_NEAR(skewed.mean_ratio, 1, 0.08);
  const Coverage heavy = measure([](auto x, auto y) { return log_normal(gradient(x, y), 2); }, 24, 2, 32, 5);
  EXPECT_GT(heavy.covered, 0.7);
  EXPECT_NEAR(heavy.mean_ratio, 1, 0.2);
}

// Neighbours tell the expectation well here, so the interval is not much wider than the scatter of
// the pixels makes it, which is .08.
TEST(PredictedError, of_much_noise_without_edges_has_a_narrow_interval) {
  const auto noise = [](auto, auto) -> PixelModel { return {1, 4, std::gamma_distribution<double>(0.25, 4)}; };
  const Coverage c = measure(noise, 48, 2, 8, 6);
  EXPECT_GT(c.covered, 0.92);
  EXPECT_LT(c.width, 0.15);
}

/// A dark disc before a bright sky, both without noise; the sky is seen through a part of the
/// pixels at its edge.
PixelModel silhouette(std::uint32_t x, std::uint32_t y) {
  const double distance = std::hypot(x - 11.5, y - 11.5), sky = std::clamp(distance - 8, 0.0, 1.0);
  return {0.2 + 0.8 * sky, 0.64 * sky * (1 - sky), [=](std::mt19937_64& random) {
            return std::uniform_real_distribution<double>(0, 1)(random) < sky ? 1.0 : 0.2;
          }};
}

// The neighbours of a pixel at the edge are the disc or the sky, and their mean says little of its
// expectation: with four samples the prediction is 1.6 times the error. The interval held the truth
// in 54 % of runs, and now in 72 %.
TEST(PredictedError, N15_the_interval_covers_the_truth_at_silhouettes_of_few_samples) {
  for (const int samples : {1, 2, 8}) {
    SCOPED_TRACE(samples);
    EXPECT_GT(measure(silhouette, 24, 2, samples, 7).covered, 0.68);
  }
}

/// A lamp of radiance 10 on a dark wall, with pixels at its edge of which it covers a part.
PixelModel at_a_lamp(std::uint32_t x, std::uint32_t y) {
  const double distance = std::hypot(x - 11.5, y - 11.5), covered = std::clamp(4.5 - distance, 0.0, 1.0);
  const PixelModel wall = normal(0.1, 0.03);
  const double mean = 10 * covered + 0.1 * (1 - covered);
  return {mean, covered * (1 - covered) * 9.9 * 9.9 + (1 - covered) * 0.03 * 0.03, [=](std::mt19937_64& random) {
            return std::uniform_real_distribution<double>(0, 1)(random) < covered ? 10.0 : wall.draw(random);
          }};
}

// The edge of a lamp was taken for outliers on the wall: the prediction was 21, 28 and 4 times the
// error. Without what was not met of it, it would be too low at few samples.
TEST(PredictedError, of_the_edges_of_lamps_is_that_of_bright_pixels) {
  EXPECT_NEAR(measure(at_a_lamp, 24, 2, 2, 8).mean_ratio, 1, 0.15);
  EXPECT_NEAR(measure(at_a_lamp, 24, 2, 8, 8).mean_ratio, 1, 0.15);
  EXPECT_NEAR(measure(at_a_lamp, 24, 2, 32, 8).mean_ratio, 1, 0.1);
}

/// The wall with `bright` in place of a share of its samples.
PixelModel wall_with(double bright, double share) {
  const PixelModel wall = normal(0.1, 0.03);
  return {bright * share + 0.1 * (1 - share), share * (1 - share) * (bright - 0.1) * (bright - 0.1) + (1 - share) * 0.03 * 0.03,
          [=](std::mt19937_64& random) {
            return std::uniform_real_distribution<double>(0, 1)(random) < share ? bright : wall.draw(random);
          }};
}

/// A lamp in every 16th pixel, which covers any part of it.
PixelModel at_small_lamps(std::uint32_t x, std::uint32_t y) {
  std::mt19937 random(x * 977 + y);
  random.discard(3);
  const double covered = x % 4 == 2 && y % 4 == 2 ? std::uniform_real_distribution<double>(0, 1)(random) : 0;
  return wall_with(10, covered);
}

// With few samples nothing can tell such lamps from outliers.
TEST(PredictedError, of_lamps_smaller_than_pixels_is_at_least_that_or_right) {
  std::mt19937_64 random(11);
  const double truth = true_relmse(at_small_lamps, 32, 2, 2);
  for (int run = 0; run < 20; ++run) {
    const PredictedError error = draw_film(at_small_lamps, 32, 2, 2, random).predicted_error();
    EXPECT_TRUE(std::isinf(error.hi));
    EXPECT_LE(error.lo, truth);
    EXPECT_GT(error.lo, truth / 10);
  }
  EXPECT_NEAR(measure(at_small_lamps, 32, 2, 64, 12).mean_ratio, 1, 0.2);
}

// As after --time, or where windows of other samples were merged: one pixel decides nothing.
TEST(PredictedError, of_pixels_with_other_numbers_of_samples_goes_by_their_mean) {
  std::mt19937_64 random(16);
  int with_both_ends = 0;
  for (int run = 0; run < 5; ++run) {
    Film film = draw_film(at_small_lamps, 32, 2, 64, random);
    const PredictedError even = film.predicted_error();
    for (std::uint32_t r = 0; r < 2; ++r) {
      for (std::uint32_t c = 0; c < 3; ++c) film.set(0, 0, r, c, to_fixed(0.1F));
      film.set_count(0, 0, r, 1);
    }
    const PredictedError uneven = film.predicted_error();
    EXPECT_NEAR(uneven.relmse, even.relmse, 0.02 * even.relmse);
    EXPECT_EQ(std::isfinite(uneven.hi), std::isfinite(even.hi));
    if (!std::isfinite(even.hi)) continue;
    EXPECT_NEAR(uneven.hi, even.hi, 0.02 * even.hi);
    ++with_both_ends;
  }
  EXPECT_GE(with_both_ends, 3);
}

// Outliers as bright as those lamps, anywhere: here the surroundings are right.
TEST(PredictedError, of_outliers_is_that_of_their_surroundings) {
  const Model outliers = [](auto, auto) { return wall_with(10, 4e-3); };
  const Coverage few = measure(outliers, 32, 2, 4, 13), many = measure(outliers, 32, 2, 32, 14);
  EXPECT_NEAR(few.mean_ratio, 1, 0.15);
  EXPECT_NEAR(many.mean_ratio, 1, 0.15);
  EXPECT_GT(few.covered, 0.85);
}

// A lamp in every 32nd pixel, which covers any part of it, and four times as many outliers: the
// lamps that both samples of a pixel hit say how few of the other bright pixels have one.
TEST(PredictedError, of_few_lamps_among_many_outliers_has_both_ends) {
  const Model model = [](std::uint32_t x, std::uint32_t y) {
    std::mt19937 random(x * 977 + y);
    random.discard(3);
    const bool is_lamp = x % 8 == 2 && y % 4 == 2;
    return wall_with(10, is_lamp ? std::uniform_real_distribution<double>(0, 1)(random) : 0.02);
  };
  const Coverage few = measure(model, 32, 2, 1, 15);
  EXPECT_GT(few.both_ends, 0.9);
  EXPECT_GT(few.covered, 0.85);
  EXPECT_NEAR(few.mean_ratio, 1, 0.12);  // 1.15 times without an outlier's own evidence (error_scale.h)
}

TEST(PredictedError, of_a_picture_in_which_nothing_was_found_has_no_upper_end) {
  Film black(small_layout(16, 16));
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x)
      for (std::uint32_t r = 0; r < 2; ++r) black.set_count(x, y, r, 100);
  EXPECT_TRUE(std::isinf(black.predicted_error().hi));
  // Samples that are all alike are another matter.
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x)
      for (std::uint32_t r = 0; r < 2; ++r) black.set(x, y, r, 1, to_fixed(100.0f));
  EXPECT_EQ(black.predicted_error().hi, 0);
}

TEST(PredictedError, is_the_closed_form_when_noise_is_small) {
  // Two replicates at mu +- d have the variance of the mean d^2: T = d^2 / (mu^2 + eps), and every
  // pixel says the same.
  Film film(small_layout(8, 8));
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x)
      for (std::uint32_t r = 0; r < 2; ++r) {
        film.set_count(x, y, r, 1);
        for (std::uint32_t c = 0; c < 3; ++c) film.set(x, y, r, c, to_fixed(r == 0 ? 0.75f : 0.5f));
      }
  const PredictedError error = film.predicted_error();
  EXPECT_NEAR(error.relmse, 0.125 * 0.125 / (0.625 * 0.625 + kEpsilon), 1e-12);
  EXPECT_LT(error.lo, error.relmse);
  EXPECT_GT(error.hi, error.relmse);
}

TEST(PredictedError, is_unknown_until_every_replicate_of_every_pixel_has_a_sample) {
  Film film(small_layout(2, 1)), single(small_layout(1, 1, 1));
  for (std::uint32_t r = 0; r < 2; ++r) film.set_count(0, 0, r, 1);
  film.set_count(1, 0, 0, 1);
  single.set_count(0, 0, 0, 64);
  EXPECT_FALSE(film.predicted_error().known);
  EXPECT_FALSE(single.predicted_error().known);
  EXPECT_TRUE(std::isnan(single.variance_of_mean(0, 0, 0)));
  film.set_count(1, 0, 1, 1);
  EXPECT_TRUE(film.predicted_error().known);
  EXPECT_EQ(film.predicted_error().relmse, 0.0);
}

TEST(PredictedError, of_a_single_pixel_has_no_upper_bound) {
  Film film(small_layout(1, 1));
  for (std::uint32_t r = 0; r < 2; ++r) {
    film.set_count(0, 0, r, 1);
    film.set(0, 0, r, 0, to_fixed(r == 0 ? 1.0f : 2.0f));
  }
  EXPECT_TRUE(std::isinf(film.predicted_error().hi));
  EXPECT_GT(film.predicted_error().relmse, 0);
}

TEST(VarianceOfMean, N15_is_unbiased_for_equal_and_unequal_counts) {
  // Samples uniform in [0, 1): the variance of the mean of N is 1 / (12 N).
  for (const std::array<std::uint64_t, 4> counts : {std::array<std::uint64_t, 4>{4, 4, 4, 4}, {1, 2, 3, 10}}) {
    std::mt19937_64 random(6);
    constexpr int kRuns = 40'000;
    const std::uint64_t all = counts[0] + counts[1] + counts[2] + counts[3];
    double mean = 0, square = 0;
    for (int run = 0; run < kRuns; ++run) {
      Film film(small_layout(1, 1, 4));
      for (std::uint32_t r = 0; r < 4; ++r) {
        int128 sum = 0;
        for (std::uint64_t i = 0; i < counts[r]; ++i)
          sum += to_fixed(std::uniform_real_distribution<float>(0, 1)(random));
        film.set(0, 0, r, 1, sum);
        film.set_count(0, 0, r, counts[r]);
      }
      const double ratio = film.variance_of_mean(0, 0, 1) * 12 * static_cast<double>(all);
      mean += ratio / kRuns;
      square += ratio * ratio / kRuns;
    }
    EXPECT_NEAR(mean, 1, 4 * std::sqrt((square - mean * mean) / kRuns));
  }
}

}  // namespace
}  // namespace eikon
