// SPDX-License-Identifier: Apache-2.0
// The predicted relMSE of an image from the spread between replicates.
//
// Wanted: T = mean over pixels and R, G, B of s^2 / (mu^2 + eps), where s^2 is the variance of the pixel's mean m and mu its
// expectation: what `compare` finds on average against the truth. s^2 has an unbiased estimate V (Film::variance_of_mean), but
// mu is unknown, and V / (m^2 + eps) is wrong in two ways:
//   - a bright outlier raises V and m together, which hides it: with two replicates and samples >= 0 the quotient never
//     exceeds 1. To first order in s the error is -2 skewness s / mu.
//   - 1 / (m^2 + eps) is curved, which adds 3 s^2 / mu^2 even without skewness.
// Against the first, mu is estimated from the 8 neighbours where the image is smooth against its noise, and from the pixel
// itself where it is not [Lee 1980, digital image enhancement by local statistics]: mu~ = w m + (1 - w) M, w = C / (C + B),
// with the noise B = mean V and the contrast C = mean of (m - M)^2 less the noise in it, both over a window of 7x7. The
// second is taken out to second order by the error v of mu~ : f(mu~) - v f''(mu~) / 2 in a form that stays positive.
//
// The interval: pixels are independent (each has its own scramble), the three channels of a pixel are not, so the pixel's mean
// over channels T_p is the unit. The variance of their sum comes from successive differences [von Neumann et al. 1941] along a
// path that goes left and right through the rows: no assumption on the distribution, and too large, never too small, by the
// contrast of T_p between neighbours. It is symmetric for log T, because a mean of squares is skewed.
//
// Assumed, then: independent replicates and pixels, and enough pixels that the worst of them do not carry the whole error. Rare
// outliers that no replicate has met are in no estimate; until they are met the interval lies too low.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/film.h"

namespace eikon {
namespace {

constexpr double kEpsilon = 1e-2;
constexpr double kQuantile = 1.959964;  // of the normal distribution, for 95 %
constexpr int kRadius = 3;              // of the window for noise and contrast

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

/// Mean over the window of +-radius, cut at the borders; by direct sums in two passes, so that one outlier cancels nothing.
Plane window_mean(const Plane& from, int radius) {
  Plane rows(from.width, from.height), result(from.width, from.height);
  for (int y = 0; y < from.height; ++y)
    for (int x = 0; x < from.width; ++x)
      for (int i = std::max(0, x - radius); i <= std::min(from.width - 1, x + radius); ++i) rows.at(x, y) += from.at(i, y);
  for (int y = 0; y < from.height; ++y) {
    const int first = std::max(0, y - radius), last = std::min(from.height - 1, y + radius);
    for (int i = first; i <= last; ++i)
      for (int x = 0; x < from.width; ++x) result.at(x, y) += rows.at(x, i);
    for (int x = 0; x < from.width; ++x) {
      const int columns = std::min(from.width - 1, x + radius) - std::max(0, x - radius) + 1;
      result.at(x, y) /= columns * (last - first + 1);
    }
  }
  return result;
}

struct Neighbours {
  double mean = 0;  // of the up to 8 around a pixel
  int count = 0;
};

Neighbours neighbours(const Plane& plane, int x, int y) {
  Neighbours result;
  for (int j = std::max(0, y - 1); j <= std::min(plane.height - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(plane.width - 1, x + 1); ++i)
      if (i != x || j != y) result.mean += plane.at(i, j), ++result.count;
  if (result.count > 0) result.mean /= result.count;
  return result;
}

/// Estimate of 1 / (mu^2 + eps) from an estimate of mu whose mean squared error is v.
double inverse_scale(double mu, double v) {
  const double f = 1 / (mu * mu + kEpsilon);
  const double c = (3 * mu * mu - kEpsilon) * f;  // f'' / 2 = c f^2, between -1 and 3
  const double relative = v * f;
  return c > 0 ? f / (1 + c * relative) : f * (1 - c * relative / (1 + relative));
}

/// Adds V / (mu^2 + eps) / 3 of one channel to each pixel.
void add_channel(const Plane& mean, const Plane& variance, Plane& error) {
  Plane surround(mean.width, mean.height), contrast(mean.width, mean.height);
  for (int y = 0; y < mean.height; ++y) {
    for (int x = 0; x < mean.width; ++x) {
      const Neighbours m = neighbours(mean, x, y), v = neighbours(variance, x, y);
      const double difference = mean.at(x, y) - m.mean;
      surround.at(x, y) = m.mean;
      if (m.count > 0) contrast.at(x, y) = difference * difference - variance.at(x, y) - v.mean / m.count;
    }
  }
  const Plane noise_mean = window_mean(variance, kRadius), contrast_mean = window_mean(contrast, kRadius);
  const bool single = mean.values.size() == 1;
  for (int y = 0; y < mean.height; ++y) {
    for (int x = 0; x < mean.width; ++x) {
      const double noise = noise_mean.at(x, y);
      if (variance.at(x, y) <= 0) continue;  // adds nothing, and noise > 0 from here on
      const double structure = std::max(0.0, contrast_mean.at(x, y));
      const double w = single ? 1 : structure / (structure + noise);
      const double mu = w * mean.at(x, y) + (1 - w) * surround.at(x, y);
      const double v = w * w * noise + (1 - w) * (1 - w) * (structure + noise / 8);
      error.at(x, y) += variance.at(x, y) * inverse_scale(mu, v) / 3;
    }
  }
}

}  // namespace

PredictedError Film::predicted_error() const {
  const Crop& crop = layout_.crop;
  const int width = static_cast<int>(crop.width()), height = static_cast<int>(crop.height());
  Plane error(width, height), mean_of(width, height), variance(width, height);
  for (std::uint32_t c = 0; c < 3; ++c) {
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y) {
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
        const std::size_t index = pixel_index(x, y);
        mean_of.values[index] = mean(x, y, c);
        variance.values[index] = variance_of_mean(x, y, c);
        if (std::isnan(variance.values[index])) return {};
      }
    }
    add_channel(mean_of, variance, error);
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
  const double factor = std::exp(kQuantile * deviation / result.relmse);
  result.lo = result.relmse / factor;
  result.hi = result.relmse * factor;
  return result;
}

}  // namespace eikon
