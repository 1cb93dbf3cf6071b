// SPDX-License-Identifier: Apache-2.0
// The predicted relMSE of an image from the spread between replicates.
//
// Wanted: T = mean over pixels and R, G, B of s^2 / (mu^2 + eps), where s^2 is the variance of the pixel's mean m and mu its
// expectation: what `compare` finds on average against the truth. s^2 has an unbiased estimate V (Film::variance_of_mean), but
// mu is unknown, and V / (m^2 + eps) is wrong in two ways:
//   - a bright outlier raises V and m together, which hides it: with two replicates and samples >= 0 the quotient never
//     exceeds 1. To first order in s the relative error is -2 skewness s / mu.
//   - 1 / (m^2 + eps) is curved, which adds 3 s^2 / mu^2 even without skewness.
// Against the first, mu is the mean of those neighbours in a window of 7x7 that lie within 1.5 sqrt(V) of m, as in the sigma
// filter [Lee 1983]. An outlier has a large V, takes in its whole surroundings and no longer hides itself; a pixel that is
// exact keeps to itself, and edges stay. The pixel's own m counts only where it has few such neighbours. The second is taken out
// to second order by the expected squared error of mu.
// What is left of the bias, on synthetic pixels (tests/unit/film_error_test.cpp): about 5 % for normal and for log-normal samples on
// gradients and edges, 11 to 13 % when neighbours have nothing to do with each other; -11 % for samples of standard deviation 7 times
// their mean at a relMSE of 0.8, -40 % for 23 times at a relMSE of 8.
//
// The interval: pixels are independent (each has its own scramble), the three channels of a pixel are not, so the pixel's mean
// over channels T_p is the unit. The variance of their sum comes from successive differences [von Neumann et al. 1941] along a
// path that goes left and right through the rows: no assumption on the distribution, and too large, never too small, by the
// contrast of T_p between neighbours. It is symmetric for log T, because a mean of squares is skewed; the bias above is allowed
// for in it, since it does not shrink with the number of pixels.
//
// Assumed, then: independent replicates and pixels, and enough pixels that the worst of them do not carry the whole error. Rare
// outliers that no replicate has met are in no estimate; until they are met, the interval lies too low.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "render/film.h"

namespace eikon {
namespace {

constexpr double kEpsilon = 1e-2;
constexpr double kQuantile = 1.959964;  // of the normal distribution, for 95 %
constexpr int kRadius = 3;              // of the window of neighbours
constexpr double kReach = 1.5;  // standard deviations of a pixel within which its neighbours may have its expectation
constexpr double kBias = 0.3,
                 kMaxBias = 0.1;  // what the tests find left of the bias: below 0.3 sqrt(T) and below 0.1 of T
constexpr double kEnough = 8;     // neighbours that make the pixel's own mean unnecessary

struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;

  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  double& at(int x, int y) { return values[index(x, y)]; }
  [[nodiscard]] double at(int x, int y) const { return values[index(x, y)]; }
};

struct Estimate {
  double mean = 0;
  double squared_error = 0;  // of the mean, expected
};

/// The expectations of a row's pixels from those around each that could have the same, to judge by its own noise.
/// own_share: what its own variance estimate must count less where it multiplies itself.
/// The window goes over the whole row, neighbour by neighbour: each pixel meets its neighbours in the order of rows, and what is
/// left out of a sum adds zero, which leaves processors with vectors to do several pixels at a time.
class RowExpectations {
 public:
  RowExpectations(const Plane& mean, const Plane& variance, int y, double own_share)
      : mean_(mean), variance_(variance), y_(y), own_share_(own_share), width_(static_cast<std::size_t>(mean.width)) {
    for (std::vector<double>* values : {&sum_, &noise_, &squares_, &count_, &candidates_}) values->resize(width_);
    for (int row = std::max(0, y - kRadius); row <= std::min(mean.height - 1, y + kRadius); ++row)
      for (int shift = -kRadius; shift <= kRadius; ++shift)
        if (row != y || shift != 0) add(row, shift);
  }

  [[nodiscard]] Estimate at(int x) const {
    const auto i = static_cast<std::size_t>(x);
    const double sum = sum_[i], count = count_[i];
    const double own_weight = std::max(0.0, 1 - count / kEnough), weight = count + own_weight;
    const double own_part = own_weight / weight;
    const double own_noise = own_part * own_part * own_share_ * variance_.at(x, y_);
    // The fewer were chosen, the more the choice follows the pixel's own error.
    const double pull = 1 - count / candidates_[i];
    const double pulled_noise = count > 0 ? pull * pull * noise_[i] / count : 0;
    const double spread = count > 0 ? std::max(0.0, squares_[i] - sum * sum / count) : 0;
    return {.mean = mean_.at(x, y_) + sum / weight,
            .squared_error = spread / (weight * weight) + std::max(own_noise, pulled_noise)};
  }

 private:
  const Plane &mean_, &variance_;
  int y_;
  double own_share_;
  std::size_t width_;
  std::vector<double> sum_, noise_, squares_, count_, candidates_;

  /// Of every pixel the neighbour so far to the right, in that row.
  void add(int row, int shift) {
    const auto begin = static_cast<std::size_t>(std::max(0, -shift));
    const auto end = static_cast<std::size_t>(std::max(0, mean_.width - std::max(0, shift)));
    const double* const own = &mean_.values[mean_.index(0, y_)];
    const double* const own_variance = &variance_.values[variance_.index(0, y_)];
    const double* const means = mean_.values.data() + mean_.index(0, row) + shift;
    const double* const variances = variance_.values.data() + variance_.index(0, row) + shift;
    double* __restrict const sum = sum_.data(), * __restrict const noise = noise_.data();
    double* __restrict const squares = squares_.data(), * __restrict const count = count_.data();
    double* __restrict const candidates = candidates_.data();
    for (std::size_t x = begin; x < end; ++x) {
      const double reach = kReach * kReach * own_variance[x];
      const double difference = means[x] - own[x], square = difference * difference;
      const bool outside = square > reach;
      sum[x] += outside ? 0.0 : difference;
      noise[x] += outside ? 0.0 : variances[x];
      squares[x] += outside ? 0.0 : square;
      count[x] += outside ? 0.0 : 1.0;
      candidates[x] += 1;
    }
  }
};

/// Estimate of 1 / (mu^2 + eps), without bias to second order in the error of mu and within 0 and 2 / eps.
double inverse_scale(const Estimate& mu) {
  const double f = 1 / (mu.mean * mu.mean + kEpsilon), relative = mu.squared_error * f;
  const double square = mu.mean * mu.mean + mu.squared_error;  // where the error is large, a small mean is no evidence
  const double c = (3 * square - kEpsilon) / (square + kEpsilon);  // f'' / 2 = c f^2, between -1 and 3
  return c > 0 ? f / (1 + c * relative) : f * (1 - c * relative / (1 + relative));
}

}  // namespace

PredictedError Film::predicted_error() const {
  const Crop& crop = layout_.crop;
  const int width = static_cast<int>(crop.width()), height = static_cast<int>(crop.height());
  // E[V^2] = (k + 2) / k s^4 for normal replicates, k = R - 1: what V itself adds to the correction must be less by that.
  const double own_share = (layout_.replicates - 1.0) / (layout_.replicates + 1.0);
  Plane error(width, height), mean_of(width, height), variance(width, height);
  std::atomic<bool> known{true};
  for (std::uint32_t c = 0; c < 3; ++c) {
    // Pixels write their own places only, so threads change no bit.
    tbb::parallel_for(crop.y0, crop.y1, [&](std::uint32_t y) {
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
        const std::size_t index = pixel_index(x, y);
        mean_of.values[index] = mean(x, y, c);
        variance.values[index] = variance_of_mean(x, y, c);
        if (std::isnan(variance.values[index])) known = false;
      }
    });
    if (!known) return {};
    tbb::parallel_for(0, height, [&](int y) {
      const RowExpectations expectations(mean_of, variance, y, own_share);
      for (int x = 0; x < width; ++x)
        if (variance.at(x, y) > 0) error.at(x, y) += variance.at(x, y) * inverse_scale(expectations.at(x)) / 3;
    });
  }

  const auto pixels = static_cast<double>(error.values.size());
  double sum = 0, differences = 0, previous = 0;
  for (int y = 0; y < height; ++y) {
    for (int i = 0; i < width; ++i) {
      const double value = error.at(y % 2 == 0 ? i : width - 1 - i, y);
      sum += value;
      if (i > 0 || y > 0) differences += (value - previous) * (value - previous);
      previous = value;
    }
  }
  PredictedError result{.relmse = sum / pixels, .lo = 0, .hi = 0, .known = true};
  if (sum == 0) return result;
  if (pixels < 2) {
    result.hi = std::numeric_limits<double>::infinity();  // one value says nothing of its spread
    return result;
  }
  const double deviation = std::sqrt(differences / 2 / (pixels * (pixels - 1)));
  const double scatter = kQuantile * deviation / result.relmse;
  const double systematic = std::min(kMaxBias, kBias * std::sqrt(result.relmse));
  const double factor = std::exp(std::hypot(scatter, systematic));
  result.lo = result.relmse / factor;
  result.hi = result.relmse * factor;
  return result;
}

}  // namespace eikon
