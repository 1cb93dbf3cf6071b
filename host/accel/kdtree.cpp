// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "accel/cells.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr double kStepCost = 1, kTriangleCost = 2,
                 kEmptyGain = 0.8;                   // relative times, and what cutting off space gains
constexpr std::size_t kBins = 32, kExactLimit = 48;  // of so few triangles all planes are tried
constexpr std::size_t kRotateLeaf = 6, kParallelLimit = 4096;
constexpr int kRotateDepth = 48;
constexpr double kRotateMost = 1.8;  // as octrees: of three splits in turn, 6 of the 8 children
constexpr std::uint64_t kMostNodes = std::uint64_t{1} << 30;
constexpr int kBadSplits = 3;  // splits in a row that seem not to pay, in the hope of one below

struct Cell {
  std::array<float, 3> lo, hi;
};

double half_area(const std::array<double, 3>& size) { return size[0] * (size[1] + size[2]) + size[1] * size[2]; }

struct Plane {
  double cost = std::numeric_limits<double>::infinity();
  float at = 0;
  std::size_t axis = 3;  // none
};

/// What the traversal reads, of a part of the tree: children and lists are numbered from its own beginning.
struct Part {
  std::vector<std::uint32_t> nodes, leaves;

  void append(const Part& other) {
    const auto node = static_cast<std::uint32_t>(nodes.size() / 2), leaf = static_cast<std::uint32_t>(leaves.size());
    for (std::size_t i = 0; i < other.nodes.size(); i += 2) {
      const std::uint32_t word = other.nodes[i + 1];
      const bool is_leaf = (word & 3U) == 3U;
      nodes.push_back(other.nodes[i] + (is_leaf ? leaf : 0));
      nodes.push_back(word + (is_leaf ? 0 : node << 2));
    }
    leaves.insert(leaves.end(), other.leaves.begin(), other.leaves.end());
  }
};

class Builder {
 public:
  Builder(const CellScene& scene, KdSplit split) : scene_(scene), split_(split) {
    // Middles come to a small object in a large scene by halves alone.
    max_depth_ = split == KdSplit::rotate
                     ? kRotateDepth
                     : 8 + static_cast<int>(1.3 * std::log2(static_cast<double>(scene.size()) + 1));
  }
  [[nodiscard]] int max_depth() const { return max_depth_; }

  void build(Part& part, CellReferences&& references, const Cell& cell, CellBudget budget, int depth, int bad) const {
    std::array<CellReferences, 2> side;
    Plane plane;
    if (depth < max_depth_ && references.size() > 1)
      plane = split_ == KdSplit::sah ? choose(references, cell) : halve(references, cell, depth, side);
    const double as_leaf = kTriangleCost * static_cast<double>(references.size());
    if (plane.cost > as_leaf) ++bad;
    const bool hopeless =
        split_ == KdSplit::sah && (bad > kBadSplits || (plane.cost > 4 * as_leaf && references.size() < 16));
    if (plane.axis == 3 || hopeless) return leaf(part, references);

    if (split_ == KdSplit::sah) divide(references, plane, side);
    const std::size_t below = side[0].size(), both = below + side[1].size();
    if (!budget.allows(both) || std::min(below, both - below) >= references.size()) return leaf(part, references);
    if (both == 0) return leaf(part, {});
    CellReferences().swap(references);
    std::array<Cell, 2> cells{cell, cell};
    cells[0].hi[plane.axis] = cells[1].lo[plane.axis] = plane.at;
    const std::array<CellBudget, 2> budgets{budget.share(below, both), budget.share(both - below, both)};

    const std::size_t node = part.nodes.size();
    part.nodes.push_back(std::bit_cast<std::uint32_t>(plane.at));
    part.nodes.push_back(static_cast<std::uint32_t>(plane.axis));
    const auto descend = [&](Part& to, std::size_t i) {
      build(to, std::move(side[i]), cells[i], budgets[i], depth + 1, bad);
    };
    const auto link_above = [&] { part.nodes[node + 1] |= static_cast<std::uint32_t>(part.nodes.size() / 2) << 2; };
    if (both < kParallelLimit) {
      descend(part, 0);
      link_above();
      descend(part, 1);
      return;
    }
    std::array<Part, 2> parts;
    tbb::parallel_invoke([&] { descend(parts[0], 0); }, [&] { descend(parts[1], 1); });
    part.append(parts[0]);
    link_above();
    part.append(parts[1]);
  }

 private:
  void leaf(Part& part, const CellReferences& references) const {
    part.nodes.push_back(static_cast<std::uint32_t>(part.leaves.size()));
    part.nodes.push_back(3U | static_cast<std::uint32_t>(references.size()) << 2);
    for (const CellReference& each : references) part.leaves.push_back(scene_.id(each.triangle));
  }

  void divide(const CellReferences& references, const Plane& plane, std::array<CellReferences, 2>& side) const {
    for (std::size_t i = 0; i < 2; ++i) {
      side[i].clear();
      CellReference cut_off;
      for (const CellReference& each : references)
        if (cut(scene_, each, plane.axis, plane.at, i, cut_off)) side[i].push_back(cut_off);
    }
  }

  /// The middle across the axis whose turn it is, with what lies on its sides. An axis along which most triangles are in both halves is
  /// passed over: entries would be spent on what is told apart along another.
  [[nodiscard]] Plane halve(const CellReferences& references, const Cell& cell, int depth,
                            std::array<CellReferences, 2>& side) const {
    if (references.size() <= kRotateLeaf) return {};
    for (std::size_t turn = 0; turn < 3; ++turn) {
      const std::size_t axis = (static_cast<std::size_t>(depth) + turn) % 3;
      const float middle = 0.5F * cell.lo[axis] + 0.5F * cell.hi[axis];
      if (!(middle > cell.lo[axis] && middle < cell.hi[axis])) continue;
      const Plane plane{0, middle, axis};
      divide(references, plane, side);
      const auto both = static_cast<double>(side[0].size() + side[1].size());
      if (both < kRotateMost * static_cast<double>(references.size())) return plane;
    }
    return {};
  }

  [[nodiscard]] Plane choose(const CellReferences& references, const Cell& cell) const {
    Plane best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (references.size() <= kExactLimit)
        sweep(references, cell, axis, best);
      else
        bins(references, cell, axis, best);
    }
    return best;
  }

  /// Takes the plane if it is cheaper than `best`. below, above: numbers of references.
  static void consider(const Cell& cell, std::size_t axis, float at, std::size_t below, std::size_t above,
                       Plane& best) {
    if (!(at > cell.lo[axis] && at < cell.hi[axis])) return;
    std::array<double, 3> whole{}, left{}, right{};
    for (std::size_t k = 0; k < 3; ++k) whole[k] = left[k] = right[k] = double{cell.hi[k]} - double{cell.lo[k]};
    left[axis] = double{at} - double{cell.lo[axis]};
    right[axis] = double{cell.hi[axis]} - double{at};
    const double area = half_area(whole);
    if (!(area > 0)) return;
    const double hits = half_area(left) * static_cast<double>(below) + half_area(right) * static_cast<double>(above);
    const double gain = below == 0 || above == 0 ? kEmptyGain : 1.0;
    const double cost = kStepCost + kTriangleCost * gain * (hits / area);
    if (cost < best.cost) best = {cost, at, axis};
  }

  static void bins(const CellReferences& references, const Cell& cell, std::size_t axis, Plane& best) {
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

  static void sweep(const CellReferences& references, const Cell& cell, std::size_t axis, Plane& best) {
    const std::size_t count = references.size();
    std::array<float, kExactLimit> begins, ends;
    for (std::size_t i = 0; i < count; ++i) begins[i] = references[i].lo[axis], ends[i] = references[i].hi[axis];
    std::sort(begins.begin(), begins.begin() + static_cast<std::ptrdiff_t>(count));
    std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
    std::size_t begun = 0, ended = 0;  // with a beginning before the plane, with an end at it or before
    while (begun < count || ended < count) {
      const float at = begun < count ? std::min(begins[begun], ends[ended]) : ends[ended];
      while (ended < count && ends[ended] <= at) ++ended;
      consider(cell, axis, at, std::max(begun, ended), count - ended, best);
      while (begun < count && begins[begun] <= at) ++begun;
    }
  }

  const CellScene& scene_;
  KdSplit split_;
  int max_depth_ = 0;
};

}  // namespace

Accel build_kdtree(TriangleSoup triangles, KdSplit split) {
  const CellScene scene(triangles);
  Accel accel = scene.begin(split == KdSplit::sah ? "kdtree" : "kdtree-rotate", "kdtree");
  const Box& box = scene.box();
  const Builder builder(scene, split);
  Part tree;
  builder.build(tree, scene.references(), {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}},
                CellBudget::of(scene.size()), 0, 0);
  accel.nodes.insert(accel.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  accel.leaves.assign(tree.leaves.begin(), tree.leaves.end());
  if (accel.leaves.empty()) accel.leaves.push_back(0);
  accel.node_count = tree.nodes.size() / 2;
  if (accel.node_count >= kMostNodes)
    throw InputError("the kd-tree has more nodes than it can number; try --accel bvh");
  accel.stack_size = static_cast<std::uint32_t>(builder.max_depth()) + 1;
  return accel;
}

}  // namespace eikon
