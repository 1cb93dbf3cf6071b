// SPDX-License-Identifier: Apache-2.0
// Tells lamps that a few pixels see from outliers, for the predicted error (film_error.cpp).
#pragma once
#include <algorithm>
#include <cmath>

#include "film/error_scale.h"

namespace eikon {

// An adjacent pixel is as bright as a pixel if its mean is at least kAlike times that of the pixel.
// This is certain if the standard deviation of its mean is at most kCertain times that mean. A
// pixel with kEnoughBright adjacent pixels that are as bright, and certainly so, is no outlier.
inline constexpr double kAlike = 0.4, kCertain = 0.35;
inline constexpr int kEnoughBright = 2;
// A pixel is bright and alone if fewer than kEnoughBright adjacent pixels are as bright, and its
// mean is more than kLoneBright times the mean of the others. It is so in both replicates if its
// mean in the dimmer one is still more than kDimmerBright times the mean of the others.
inline constexpr double kLoneBright = 5, kDimmerBright = 2.5;

/// True if a pixel is brighter than what its surroundings say of it, and yet no outlier, because
/// pixels beside it are as bright without doubt.
inline bool is_edge_of_lamp(const Plane& mean, const Plane& variance, int x, int y, const Estimate<double>& mu) {
  if (mu.mean >= kAlike * mean.at(x, y)) return false;
  int bright = 0;
  for (int j = std::max(0, y - 1); j <= std::min(mean.height - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(mean.width - 1, x + 1); ++i) {
      const double other = mean.at(i, j), doubt = kCertain * other;
      const bool is_bright = other >= kAlike * mean.at(x, y) && variance.at(i, j) <= doubt * doubt;
      bright += is_bright && (i != x || j != y) ? 1 : 0;
    }
  return bright >= kEnoughBright;
}

/// The replicates in which a pixel is bright and alone, of two.
inline int lone_bright_replicates(const Plane& mean, const Plane& variance, int x, int y) {
  const double own = mean.at(x, y);
  if (own * own <= kErrorEpsilon) return 0;
  double dark = 0;
  int alike = 0, others = 0;
  for (int j = std::max(0, y - 1); j <= std::min(mean.height - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(mean.width - 1, x + 1); ++i) {
      if (i == x && j == y) continue;
      const double other = mean.at(i, j);
      if (other < kAlike * own) {
        ++others, dark += other;
      } else if (++alike == kEnoughBright) {
        return 0;  // most pixels end here
      }
    }
  if (own * others <= kLoneBright * dark || others == 0) return 0;
  const double dimmer = own - std::sqrt(variance.at(x, y));
  return dimmer * others > kDimmerBright * dark ? 2 : 1;
}

/// The pixels that a lamp of uniformly distributed coverage brightens in one of two replicates,
/// over those that it brightens in both. samples: of a replicate
inline double lone_ratio_of_lamps(double samples) {
  const double none_in_one = 1 / (samples + 1), none_in_both = 1 / (2 * samples + 1);
  return 2 * (none_in_one - none_in_both) / (1 - 2 * none_in_one + none_in_both);
}

}  // namespace eikon
