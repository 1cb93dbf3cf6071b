// SPDX-License-Identifier: Apache-2.0
#include "film/neighbours.h"

#include <algorithm>
#include <cstring>

namespace eikon {
namespace {

// Neighbours within so many standard deviations of a pixel may have its expectation.
constexpr double kReach = 1.5;

}  // namespace

EK_CLONES void find_neighbours(const Plane& mean, const Plane& variance, int x, int y,
                               std::array<Neighbours<PixelReals, PixelMasks>, kPixelGroups>& found) {
  std::array<PixelReals, kPixelGroups> own, reach, sum{}, noise{}, squares{};
  std::array<PixelMasks, kPixelGroups> count{};
  for (std::size_t g = 0; g < kPixelGroups; ++g) {
    load_pixels(mean, x + static_cast<int>(g) * kPixelLanes, y, own[g]);
    load_pixels(variance, x + static_cast<int>(g) * kPixelLanes, y, reach[g]);
    reach[g] *= kReach * kReach;
  }
  for (int j = std::max(0, y - kNeighbourRadius); j <= std::min(mean.height - 1, y + kNeighbourRadius); ++j) {
    const double *const means = &mean.values[mean.index(x, j)], *const variances = &variance.values[mean.index(x, j)];
#pragma GCC unroll 7
    for (int i = -kNeighbourRadius; i <= kNeighbourRadius; ++i) {
      if (i == 0 && j == y) continue;
#pragma GCC unroll 2
      for (std::size_t g = 0; g < kPixelGroups; ++g) {
        PixelReals other, its_noise;
        std::memcpy(&other, means + g * kPixelLanes + i, sizeof other);
        std::memcpy(&its_noise, variances + g * kPixelLanes + i, sizeof its_noise);
        const PixelReals difference = other - own[g], square = difference * difference;
        const PixelMasks inside = ~(square > reach[g]);
        sum[g] += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(difference));
        noise[g] += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(its_noise));
        squares[g] += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(square));
        count[g] -= inside;  // which is -1
      }
    }
  }
  for (std::size_t g = 0; g < kPixelGroups; ++g) found[g] = {sum[g], noise[g], squares[g], count[g]};
}

Neighbours<double, int> neighbours_of(const Plane& mean, const Plane& variance, int x, int y) {
  const double own = mean.at(x, y), reach = kReach * kReach * variance.at(x, y);
  Neighbours<double, int> found;
  for (int j = std::max(0, y - kNeighbourRadius); j <= std::min(mean.height - 1, y + kNeighbourRadius); ++j) {
    for (int i = std::max(0, x - kNeighbourRadius); i <= std::min(mean.width - 1, x + kNeighbourRadius); ++i) {
      const double difference = mean.at(i, j) - own, square = difference * difference;
      if (square > reach || (i == x && j == y)) continue;
      found.sum += difference;
      found.noise += variance.at(i, j);
      found.squares += square;
      ++found.count;
    }
  }
  return found;
}

int candidates_of(const Plane& mean, int x, int y) {
  const int columns = std::min(mean.width - 1, x + kNeighbourRadius) - std::max(0, x - kNeighbourRadius) + 1;
  const int rows = std::min(mean.height - 1, y + kNeighbourRadius) - std::max(0, y - kNeighbourRadius) + 1;
  return columns * rows - 1;
}

}  // namespace eikon
