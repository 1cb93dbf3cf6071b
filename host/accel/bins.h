// SPDX-License-Identifier: Apache-2.0
// Binned splits of many triangles: boxes and counts of the bins of centroids, along the three axes
// at once.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "accel/box.h"

namespace eikon {

inline constexpr std::size_t kBins = 32;

/// Maps twice a centroid to a bin per axis; an axis without extent has one bin.
struct BinMap {
  std::size_t bins;  // fewer for few triangles
  Float4 base, scale, last;
  BinMap(const Box& centroids, std::size_t count)
      : bins(std::min(kBins, 4 + count / 4)),
        base(centroids.lo),
        scale(splat4(0)),
        last(splat4(static_cast<float>(bins - 1))) {
    for (int axis = 0; axis < 3; ++axis) {
      const float s = static_cast<float>(bins) * 0.99999F / (centroids.hi[axis] - centroids.lo[axis]);
      scale[axis] = std::isfinite(s) ? s : 0.0F;
    }
  }
  [[nodiscard]] Int4 operator()(Float4 c) const {
    const Float4 x = min4(max4((c - base) * scale, splat4(0)), last);  // NaN becomes 0
    return __builtin_convertvector(x, Int4);
  }
};

/// A plane between two bins. It gives the same side as the bins, from one axis of the centroid.
struct BinPlane {
  std::size_t axis;
  float base, scale, first_right;
  [[nodiscard]] bool is_right(const Reference& r) const {
    return (r.lo[axis] + r.hi[axis] - base) * scale >= first_right;  // NaN is left, as bin 0 is
  }
};

struct BinSplit {
  float cost = std::numeric_limits<float>::infinity();  // infinite: no plane separates the centroids
  std::size_t axis = 0, first_right = 0;                // bin
  std::array<Box, 2> boxes;                             // of the two sides
  [[nodiscard]] BinPlane plane(const BinMap& map) const {
    return {axis, map.base[axis], map.scale[axis], static_cast<float>(first_right)};
  }
};

class Bins {
 public:
  explicit Bins(std::size_t bins) {
    for (std::size_t b = 0; b < bins; ++b) {
      boxes_[b] = Box3{};
      counts_[b] = Int4{};
    }
  }
  void add(const Reference& r, const BinMap& map) {
    const Int4 bin = map(centroid2(r));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto b = static_cast<std::size_t>(bin[axis]);
      boxes_[b][axis].add(r.box());
      ++counts_[b][axis];
    }
  }
  void add(const Bins& other, std::size_t bins) {
    for (std::size_t b = 0; b < bins; ++b) {
      for (std::size_t axis = 0; axis < 3; ++axis) boxes_[b][axis].add(other.boxes_[b][axis]);
      counts_[b] += other.counts_[b];
    }
  }
  [[nodiscard]] std::size_t count_left(const BinSplit& split) const {
    std::size_t count = 0;
    for (std::size_t b = 0; b < split.first_right; ++b) count += static_cast<std::size_t>(counts_[b][split.axis]);
    return count;
  }

  [[nodiscard]] BinSplit best_split(std::size_t bins) const {
    std::array<Float4, kBins> right_cost;
    Box3 boxes;
    Int4 count{};
    for (std::size_t b = bins - 1; b > 0; --b) {
      for (std::size_t axis = 0; axis < 3; ++axis) boxes[axis].add(boxes_[b][axis]);
      count += counts_[b];
      right_cost[b] = half_areas(boxes) * count_costs(count);
    }
    boxes = Box3{};
    count = Int4{};
    Float4 best_cost = splat4(std::numeric_limits<float>::infinity());
    Int4 best_bin{};
    for (std::size_t b = 1; b < bins; ++b) {
      for (std::size_t axis = 0; axis < 3; ++axis) boxes[axis].add(boxes_[b - 1][axis]);
      count += counts_[b - 1];
      const Float4 cost = half_areas(boxes) * count_costs(count) + right_cost[b];
      const Int4 better = cost < best_cost;  // false if a side is empty, because its area is infinite
      best_cost = better ? cost : best_cost;
      best_bin = better ? Int4{} + static_cast<std::int32_t>(b) : best_bin;
    }
    BinSplit best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (best_cost[axis] < best.cost) {
        best.cost = best_cost[axis];
        best.axis = axis;
        best.first_right = static_cast<std::size_t>(best_bin[axis]);
      }
    }
    for (std::size_t b = 0; b < bins; ++b) best.boxes[b < best.first_right ? 0 : 1].add(boxes_[b][best.axis]);
    return best;
  }

 private:
  union {  // unset until the constructor sets those in use
    std::array<Box3, kBins> boxes_;
  };
  union {
    std::array<Int4, kBins> counts_;
  };
};

}  // namespace eikon
