// SPDX-License-Identifier: Apache-2.0
#include "film/neighbours.h"

#include <algorithm>
#include <cstring>

namespace eikon {
namespace {

// Neighbours within so many standard deviations of a pixel may have its expectation.
constexpr double kReach = 1.5;

}  // namespace

#ifdef __SANITIZE_THREAD__
// The resolver that chooses a clone runs before ThreadSanitizer is ready, and would crash.
#define EK_CLONES
#else
#define EK_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#endif

EK_CLONES void find_neighbours(const Plane& mean, const Plane& variance, int x, int y,
                               Neighbours<PixelReals, PixelMasks>& found) {
  PixelReals own, reach;
  std::memcpy(&own, &mean.values[mean.index(x, y)], sizeof own);
  std::memcpy(&reach, &variance.values[mean.index(x, y)], sizeof reach);
  reach *= kReach * kReach;
  PixelReals sum{}, noise{}, squares{};
  PixelMasks count{};
  for (int j = std::max(0, y - kNeighbourRadius); j <= std::min(mean.height - 1, y + kNeighbourRadius); ++j) {
    for (int i = x - kNeighbourRadius; i <= x + kNeighbourRadius; ++i) {
      if (i == x && j == y) continue;
      PixelReals other, its_noise;
      std::memcpy(&other, &mean.values[mean.index(i, j)], sizeof other);
      std::memcpy(&its_noise, &variance.values[mean.index(i, j)], sizeof its_noise);
      const PixelReals difference = other - own, square = difference * difference;
      const PixelMasks inside = ~(square > reach);
      sum += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(difference));
      noise += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(its_noise));
      squares += reinterpret_cast<PixelReals>(inside & reinterpret_cast<PixelMasks>(square));
      count -= inside;  // which is -1
    }
  }
  found.sum = sum, found.noise = noise, found.squares = squares, found.count = count;
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
