// SPDX-License-Identifier: Apache-2.0
// The predicted relMSE of an image from the spread between replicates.
//
// The quantity. T is the mean over pixels and R, G, B of s^2 / (mu^2 + eps), where s^2 is the
// variance of the pixel's mean m, and mu is the expectation of m. It is what `compare` finds on
// average against the true image. s^2 has an unbiased estimate V (Film::variance_of_mean), but mu
// is unknown, and V / (m^2 + eps) is wrong in two ways:
//   - A bright outlier raises V and m together, which hides it. With two replicates and samples >=
//     0 the quotient never exceeds 1. To first order in s the relative error is -2 skewness s / mu.
//   - 1 / (m^2 + eps) is curved, which adds 3 s^2 / mu^2 even without skewness.
//
// Against the first, mu is estimated by the mean of those neighbours in a window of 7x7 that lie
// within 1.5 sqrt(V) of m, as in the sigma filter [Lee 1983]. An outlier has a large V, so it takes
// in its whole surroundings and no longer hides itself. An exact pixel takes in no other, and edges
// stay. The pixel's own m counts only where it has few such neighbours. The second error is removed
// to second order by the expected squared error of mu.
//
// The edge of a lamp looks like an outlier: it is bright, its V is large, and its surroundings are
// dark. But an outlier is in one replicate, and stands alone. So where the surroundings say that a
// pixel's mu is less than 0.4 m, and two or more adjacent pixels are as bright without doubt (both
// of their replicates are), m itself counts. In scenes/cornell.gltf of 96x96 pixels the prediction
// at 16 samples was 1.41 times the error, and is 1.03. Of the pixels at the edge of a lamp, those
// that hardly a sample saw brighten have no variance, or too bright a mean. So the error of those
// that were met counts 1 + 6 / samples times.
//
// A lamp smaller than a pixel stands alone, too, and no single sample can tell whether it hit such
// a lamp or was an outlier. If it was taken for the wrong one, the prediction would be wrong by a
// factor of 1.5 to 3,000. Two replicates and all pixels together can tell:
//   - A pixel that is bright in both replicates has a lamp, since outliers rarely fall twice on one
//     pixel, and its own m counts.
//   - Of lamps that cover any part of a pixel with the same probability, the lone pixels that are
//     bright in one replicate are a known multiple of those that are in both. Where they are twice
//     as many, or more, they are outliers.
//   - Where they are fewer, they may be lamps. With 32 samples and more in a replicate, as many of
//     them as lamps would give are taken for lamps. With fewer samples nothing can be said: if more
//     than a fifth of the prediction depends on it, the error is stated to be at least what it
//     would be if all were lamps.
// With 8 seeds each, from 4 to 64 samples, they are more often than not 2 to 60 times as many where
// they are outliers (scenes/cornell_spheres.gltf, prism, sun_room, tumbler and window_room), and 0
// to 3 times in scenes/lamps.gltf. If few pixels carry what was taken for outliers, that choice is
// uncertain, and the interval is wider by the share of the prediction that rests on it.
//
// The remaining bias, measured on synthetic pixels (tests/unit/film/film_error_test.cpp), is about
// 5 % for normal and for log-normal samples on gradients and edges, 12 % when neighbours are
// unrelated, and -16 % for samples of standard deviation 7 times their mean at a relMSE of 0.8.
//
// The interval. Pixels are independent, because each has its own scramble; the three channels of a
// pixel are not. So the unit is T_p, the mean over the channels of a pixel. The variance of the sum
// of T_p comes from successive differences [von Neumann et al. 1941] along a path that goes left
// and right through the rows. This assumes nothing about the distribution, and it is too large,
// never too small, by the contrast of T_p between neighbours. The interval is symmetric for log T,
// because a mean of squares is skewed. It also allows for a bias, which does not shrink with the
// number of pixels. Its size comes from the picture (error_scale.h): the share of T that the
// correction to second order makes up, since the orders above it are left out; and the share that
// edges make uncertain. The neighbours of a pixel at an edge are those of both sides, which differ
// by more than their noise, and its mu may be anywhere between. So a noisy room without many edges
// has a narrow interval, and a bright silhouette of few samples a wide one.
//
// The interval has no upper end if fewer than four pixels carry the whole error, or if nothing but
// black was found: the error is at least as large as the lower end, which is that of one normal
// square.
//
// The assumptions are independent replicates and pixels, and enough pixels that the worst of them
// do not carry the whole error. No estimate contains rare outliers that no replicate has met; until
// one is met, the interval lies too low.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "film/bright_pixels.h"
#include "film/error_scale.h"
#include "film/film.h"
#include "film/neighbours.h"

namespace eikon {
namespace {

constexpr double kQuantile = 1.959964;  // quantile of the normal distribution for 95 %
// The bias that tools/measure/coverage.py finds where neither correction nor edges tell of one,
// relative to T; the latter over the root of the samples of a pixel.
constexpr double kMinBias = 0.03, kBiasOfSamples = 0.2;
// The error at the edges of lamps that no sample met is that which was met, times this number over
// the samples of a pixel. With it 100 instead of 71 % of the intervals of `cornell` with 4 samples
// hold the truth, and 93 instead of 85 % of `lamps` with 16.
constexpr double kUnmetOfEdges = 6;
// The ratio to what lamps would give from which on lone bright pixels are outliers, the samples of
// a replicate from which on lamps can be told otherwise, and the share of the prediction that may
// be in doubt with fewer.
constexpr double kOutliers = 2, kSamplesOfLamps = 32, kMaxInDoubt = 0.2;
// The interval allows for all of the share of the prediction that rests on outliers where so many
// pixels carry that share, by (sum)^2 / (sum of squares), and for less where more do.
constexpr double kFewOutliers = 5;
// The error has no upper bound where fewer pixels carry it, by (sum T_p)^2 / sum T_p^2.
constexpr double kMinCarriers = 4;
constexpr double kChiSquared = 5.0239;  // quantile of chi squared with one degree of freedom for 97.5 %

/// The sums over the neighbours of kPixelsTogether pixels of a row, and the errors of these pixels.
struct PixelsInRow {
  std::array<Neighbours<PixelReals, PixelMasks>, kPixelGroups> near;
  std::array<PixelReals, kPixelGroups> error;  // of pixels that look like no outlier and no lamp
  std::array<PixelReals, kPixelGroups> correction, edges;  // what is uncertain of it
  std::array<PixelMasks, kPixelGroups> rare;   // not 0 where that is not certain
};

/// Finds the errors of pixels x to x + kPixelsTogether - 1, whose windows lie within the row.
EK_CLONES void find_errors(const Plane& mean, const Plane& variance, int x, int y, double own_share, PixelsInRow& pixels) {
  for (std::size_t g = 0; g < kPixelGroups; ++g) {
    const int at = x + static_cast<int>(g) * kPixelLanes;
    PixelReals own, noise;
    load_pixels(mean, at, y, own);
    load_pixels(variance, at, y, noise);
    PixelMasks alike{};
    for (int j = std::max(0, y - 1); j <= std::min(mean.height - 1, y + 1); ++j)
      for (int i = -1; i <= 1; ++i) {
        if (i == 0 && j == y) continue;
        PixelReals other;
        load_pixels(mean, at + i, j, other);
        alike += other < kAlike * own;  // -1
      }
    alike += (y > 0 ? 3 : 0) + (y < mean.height - 1 ? 3 : 0) + 2;
    const auto& [sum, noises, squares, count] = pixels.near[g];
    Estimate<PixelReals> around;
    expectation<PixelReals>(own, noise, {sum, noises, squares, __builtin_convertvector(count, PixelReals)},
                            candidates_of(mean, x, y), own_share, around);
    PixelReals scale, none{};
    inverse_scale(around, scale);
    const PixelMasks noisy = noise > none;
    pixels.error[g] = noisy ? noise * scale / 3 : none;
    part_of_correction<PixelReals>(around, scale, pixels.error[g], pixels.correction[g]);
    part_of_edges<PixelReals>(around, pixels.error[g], pixels.edges[g]);
    pixels.rare[g] = (noisy & (around.mean < kAlike * own)) | ((own * own > kErrorEpsilon) & (alike < kEnoughBright));
  }
}

/// The part of the prediction that depends on whether bright pixels are outliers or lamps.
struct Doubt {
  double share = 0;       // for which the interval allows
  bool at_least = false;  // no upper end can be stated
};

/// The parts of an error that depend on the second-order correction, and on edges.
struct Uncertainty {
  double correction = 0, edges = 0;
  double of_disputed = 0;  // correction of the errors that are taken away if bright pixels are lamps
};

/// T_p of each pixel.
class PixelErrors {
 public:
  /// replicates: of the image; lamps are told from outliers where there are two
  /// samples: of a pixel, on average
  PixelErrors(int width, int height, std::uint32_t replicates, double samples)
      : error_(width, height),
        disputed_(width, height),
        rows_(static_cast<std::size_t>(height)),
        // For normal replicates E[V^2] = (k + 2) / k s^4 with k = R - 1, so V counts less by that
        // factor.
        own_share_((replicates - 1.0) / (replicates + 1.0)),
        samples_(samples),
        has_pairs_(replicates == 2) {
    std::ranges::fill(error_.values, 0.0);
    std::ranges::fill(disputed_.values, 0.0);
  }

  /// Adds a channel in some rows. The planes have rows from `from` of the image on, and the windows
  /// of these pixels.
  void add(const Plane& mean, const Plane& variance, int from, int first, int last) {
    for (int y = first; y < last; ++y)
      for (int x = 0; x < mean.width;) {
        if (x < kNeighbourRadius || x + kPixelsTogether + kNeighbourRadius > mean.width) {
          const int row = y - from;
          add(mean, variance, x, row, neighbours_of(mean, variance, x, row), y);
          ++x;
        } else {
          add_together(mean, variance, x, y - from, y);
          x += kPixelsTogether;
        }
      }
  }

  /// Decides whether pixels that are bright in one of two replicates are outliers or lamps.
  Doubt settle() {
    const double samples = samples_ / 2;  // of a replicate
    double all = 0, sum = 0, squares = 0;
    for (std::size_t i = 0; i < error_.values.size(); ++i) {
      const double disputed = disputed_.values[i];
      all += error_.values[i], sum += disputed, squares += disputed * disputed;
    }
    if (sum <= 0) return {};
    const double as_lamps = lone_ratio_of_lamps(samples) * std::max(1, twice_.load()), once = once_.load();
    Doubt doubt{.share = sum / all * std::min(1.0, kFewOutliers * squares / (sum * sum))};
    if (once >= kOutliers * as_lamps) return doubt;
    doubt.at_least = samples < kSamplesOfLamps && sum > kMaxInDoubt * all;
    if (samples < kSamplesOfLamps && !doubt.at_least) return doubt;
    lamps_ = doubt.at_least || once <= as_lamps ? 1 : as_lamps / once;
    for (std::size_t i = 0; i < error_.values.size(); ++i) error_.values[i] -= lamps_ * disputed_.values[i];
    return doubt;
  }
  [[nodiscard]] const Plane& error() const { return error_; }
  /// The parts of the sum of all errors; after settle().
  [[nodiscard]] Uncertainty uncertainty() const {
    Uncertainty all;
    for (const Uncertainty& row : rows_) {
      all.correction += row.correction + (1 - lamps_) * row.of_disputed;
      all.edges += row.edges;
    }
    return all;
  }

 private:
  /// Adds a channel of pixels x to x + kPixelsTogether - 1, whose windows lie within the row.
  /// y: row of the planes; image_y: of the image
  void add_together(const Plane& mean, const Plane& variance, int x, int y, int image_y) {
    const double* const noise = &variance.values[variance.index(x, y)];
    PixelsInRow pixels{};
    // Without noise, no neighbour matters: pixels of a sky or in a black room.
    if (std::any_of(noise, noise + kPixelsTogether, [](double value) { return value > 0; }))
      find_neighbours(mean, variance, x, y, pixels.near);
    find_errors(mean, variance, x, y, own_share_, pixels);
    Uncertainty& uncertain = rows_[static_cast<std::size_t>(image_y)];
    for (int i = 0; i < kPixelsTogether; ++i) {
      const auto group = static_cast<std::size_t>(i / kPixelLanes), lane = static_cast<std::size_t>(i % kPixelLanes);
      const Neighbours<PixelReals, PixelMasks>& near = pixels.near[group];
      if (pixels.rare[group][lane] == 0) {
        error_.at(x + i, image_y) += pixels.error[group][lane];
        uncertain.correction += pixels.correction[group][lane];
        uncertain.edges += pixels.edges[group][lane];
      } else {
        add(mean, variance, x + i, y,
            {near.sum[lane], near.noise[lane], near.squares[lane], static_cast<int>(near.count[lane])}, image_y);
      }
    }
  }

  void add(const Plane& mean, const Plane& variance, int x, int y, const Neighbours<double, int>& near, int image_y) {
    const double noise = variance.at(x, y);
    const int bright = has_pairs_ ? lone_bright_replicates(mean, variance, x, y) : 0;
    // Rare, so that threads do not wait for each other's counts.
    if (bright == 1) ++once_;
    if (bright == 2) ++twice_;
    if (noise <= 0) return;
    const Estimate<double> own{mean.at(x, y), own_share_ * noise};
    Estimate<double> around;
    expectation<double>(own.mean, noise, {near.sum, near.noise, near.squares, double(near.count)},
                        candidates_of(mean, x, y), own_share_, around);
    const double dimmer = own.mean - std::sqrt(noise);  // of two replicates
    const bool is_brighter = around.mean < kAlike * own.mean, is_edge = is_edge_of_lamp(mean, variance, x, y, around),
               in_both = has_pairs_ && dimmer > kDimmerBright * around.mean;
    if (is_brighter) add_own_evidence(own.mean, dimmer, has_pairs_ ? kDimmerWeight * samples_ : 0, near.count, around);
    const double scale = inverse_scale(around), as_lamp = noise * inverse_scale(own) / 3,
                 as_outlier = noise * scale / 3;
    double& error = error_.at(x, image_y);
    Uncertainty part;
    part_of_correction(around, scale, as_outlier, part.correction);
    part_of_edges(around, as_outlier, part.edges);
    Uncertainty& uncertain = rows_[static_cast<std::size_t>(image_y)];
    if (!is_brighter) {
      error += as_outlier;
      uncertain.correction += part.correction, uncertain.edges += part.edges;
      return;
    }
    if (is_edge) {
      error += (1 + kUnmetOfEdges / samples_) * as_lamp;
      return;
    }
    error += in_both ? as_lamp : as_outlier;
    if (in_both) return;
    disputed_.at(x, image_y) += as_outlier - as_lamp;
    uncertain.of_disputed += part.correction;
  }

  // kErrorBytesPerPixel: a number in each, the latter of what would be taken away if pixels that
  // are bright in one replicate were lamps.
  Plane error_, disputed_;
  std::vector<Uncertainty> rows_;  // each row has its own, which one thread adds to
  double own_share_, samples_;
  bool has_pairs_;
  double lamps_ = 0;                     // share of the disputed errors that were taken for lamps
  std::atomic<int> once_{0}, twice_{0};  // channels of pixels that are bright and alone in one replicate, and in both
};

/// The mean over all pixels, and its interval. samples: of a pixel, on average
PredictedError interval_of(const Plane& error, const Uncertainty& uncertain, const Doubt& doubt, double samples) {
  const auto pixels = static_cast<double>(error.values.size());
  double sum = 0, squares = 0, differences = 0, previous = 0;
  for (int y = 0; y < error.height; ++y) {
    for (int i = 0; i < error.width; ++i) {
      const double value = error.at(y % 2 == 0 ? i : error.width - 1 - i, y);
      sum += value;
      squares += value * value;
      if (i > 0 || y > 0) differences += (value - previous) * (value - previous);
      previous = value;
    }
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double mean = sum / pixels;
  PredictedError result{.relmse = mean, .lo = mean, .hi = mean, .known = true};
  if (sum == 0) return result;
  if (pixels < kMinCarriers || sum * sum < kMinCarriers * squares) {
    result.lo = mean / kChiSquared;
    result.hi = kInfinity;
    return result;
  }
  result.scatter = std::sqrt(differences / 2 / (pixels * (pixels - 1))) / mean;
  result.bias = std::hypot(std::hypot(kMinBias, kBiasOfSamples / std::sqrt(samples)),
                           std::hypot(uncertain.correction, uncertain.edges) / sum, doubt.share);
  const double factor = std::exp(std::hypot(kQuantile * result.scatter, result.bias));
  result.lo = mean / factor;
  result.hi = doubt.at_least ? kInfinity : mean * factor;
  return result;
}

/// The quantile of the standard normal distribution that lies above 0: exceeded with this
/// probability below 1/2.
double normal_quantile(double probability) {
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / std::numbers::sqrt2) > probability ? low : high) = middle;
  }
  return low;
}

}  // namespace

double PredictedError::upper(double probability) const {
  if (!known || !std::isfinite(hi)) return std::numeric_limits<double>::infinity();
  return relmse * std::exp(std::hypot(normal_quantile(probability) * scatter, bias));
}

double Film::mean_samples() const {
  const Crop& crop = layout_.crop;
  std::uint64_t sum = 0;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x) sum += samples(x, y);
  return static_cast<double>(sum) / static_cast<double>(std::uint64_t{crop.width()} * crop.height());
}

PredictedError Film::predicted_error() const {
  const Crop& crop = layout_.crop;
  const int width = static_cast<int>(crop.width()), height = static_cast<int>(crop.height());
  const double samples = mean_samples();
  PixelErrors errors(width, height, layout_.replicates, samples);
  std::atomic<bool> known{true}, lit{false};
  // In bands of rows, whose numbers stay in the processor's caches. Each pixel writes only its own
  // elements, so the number of threads changes no bit.
  constexpr int kBand = 32;
  tbb::parallel_for(0, (height + kBand - 1) / kBand, [&](int band) {
    const int first = band * kBand, last = std::min(first + kBand, height);
    const int from = std::max(0, first - kNeighbourRadius), to = std::min(height, last + kNeighbourRadius);
    std::array<Plane, 3> mean{Plane(width, to - from), Plane(width, to - from), Plane(width, to - from)}, variance = mean;
    for (int y = from; y < to; ++y)
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::span<double> means(&mean[c].at(0, y - from), crop.width()), row(&variance[c].at(0, y - from), crop.width());
        row_means_and_variances(crop.y0 + static_cast<std::uint32_t>(y), c, means.data(), row.data());
        if (std::ranges::any_of(row, [](double value) { return std::isnan(value); })) known = false;
        if (std::ranges::any_of(means, [](double value) { return value != 0; })) lit = true;
      }
    for (std::uint32_t c = 0; c < 3 && known; ++c) errors.add(mean[c], variance[c], from, first, last);
  });
  if (!known) return {};
  const Doubt doubt = layout_.replicates == 2 ? errors.settle() : Doubt{};
  PredictedError result = interval_of(errors.error(), errors.uncertainty(), doubt, samples);
  // Samples that are all alike have no error, unless none of them has found any light.
  if (result.relmse == 0 && !lit) result.hi = std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace eikon
