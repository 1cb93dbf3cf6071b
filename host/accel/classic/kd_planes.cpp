// SPDX-License-Identifier: Apache-2.0
// Finds the best plane across an axis of a cell.
#include <algorithm>
#include <cmath>

#include "accel/classic/kd_builder.h"

namespace eikon {
namespace {

constexpr std::size_t kBins = 32, kExactLimit = 48;  // up to this many triangles all planes are tried

double half_area(const std::array<double, 3>& size) { return size[0] * (size[1] + size[2]) + size[1] * size[2]; }

/// Takes the plane if it is cheaper than `best`. below, above: numbers of references.
void consider(const KdCell& cell, std::size_t axis, float at, std::size_t below, std::size_t above, KdPlane& best) {
  if (!(at > cell.lo[axis] && at < cell.hi[axis])) return;
  std::array<double, 3> whole{}, left{}, right{};
  for (std::size_t k = 0; k < 3; ++k) whole[k] = left[k] = right[k] = double{cell.hi[k]} - double{cell.lo[k]};
  left[axis] = double{at} - double{cell.lo[axis]};
  right[axis] = double{cell.hi[axis]} - double{at};
  const double area = half_area(whole);
  if (!(area > 0)) return;
  const double hits = half_area(left) * static_cast<double>(below) + half_area(right) * static_cast<double>(above);
  const double gain = below == 0 || above == 0 ? kKdEmptyGain : 1.0;
  const double cost = kKdStepCost + kKdTriangleCost * gain * (hits / area);
  if (cost < best.cost) best = {cost, at, axis};
}

void bins(const CellReferences& references, const KdCell& cell, std::size_t axis, KdPlane& best) {
  float lo = cell.hi[axis], hi = cell.lo[axis];
  for (const CellReference& each : references) lo = std::min(lo, each.lo[axis]), hi = std::max(hi, each.hi[axis]);
  const float scale = static_cast<float>(kBins) / (hi - lo);
  std::array<std::size_t, kBins + 1> begins{}, ends{};
  const auto bin = [&](float x) {
    const float b = (x - lo) * scale;
    return b > 0 ? std::min(static_cast<std::size_t>(std::min(b, 1e6F)), kBins - 1) : 0;
  };
  if (!(hi > lo) || !std::isfinite(scale)) {
    consider(cell, axis, lo, references.size(), 0, best);
    return;
  }
  for (const CellReference& each : references) ++begins[bin(each.lo[axis])], ++ends[bin(each.hi[axis])];
  consider(cell, axis, lo, 0, references.size(), best);
  consider(cell, axis, hi, references.size(), 0, best);
  std::size_t begun = 0, ended = 0;
  for (std::size_t b = 0; b + 1 < kBins; ++b) {
    begun += begins[b];
    ended += ends[b];
    const float at = lo + (hi - lo) * (static_cast<float>(b + 1) / static_cast<float>(kBins));
    consider(cell, axis, at, begun, references.size() - ended, best);
  }
}

void sweep(const CellReferences& references, const KdCell& cell, std::size_t axis, KdPlane& best) {
  const std::size_t count = references.size();
  std::array<float, kExactLimit> begins, ends;
  for (std::size_t i = 0; i < count; ++i) begins[i] = references[i].lo[axis], ends[i] = references[i].hi[axis];
  std::sort(begins.begin(), begins.begin() + static_cast<std::ptrdiff_t>(count));
  std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  std::size_t begun = 0, ended = 0;  // that begin before the plane; that end at it or before
  while (begun < count || ended < count) {
    const float at = begun < count ? std::min(begins[begun], ends[ended]) : ends[ended];
    while (ended < count && ends[ended] <= at) ++ended;
    consider(cell, axis, at, std::max(begun, ended), count - ended, best);
    while (begun < count && begins[begun] <= at) ++begun;
  }
}

}  // namespace

KdPlane cheapest_plane(const CellReferences& references, const KdCell& cell) {
  KdPlane best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (references.size() <= kExactLimit)
      sweep(references, cell, axis, best);
    else
      bins(references, cell, axis, best);
  }
  return best;
}

}  // namespace eikon
