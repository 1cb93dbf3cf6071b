// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/builders.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "accel/classic/kd_builder.h"
#include "core/error.h"

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

namespace {

constexpr std::size_t kRotateLeaf = 4, kParallelLimit = 4096;
constexpr int kRotateDepth = 48;
constexpr double kRotateMost = 1.7;  // most references on both sides, per reference of the node

// Words of a node, two for an index (kernels/traverse/classic/kdtree.h).
constexpr std::uint32_t kLeaf = 3, kOblique = 4, kKindBits = 3, kKindMask = 7;
constexpr std::size_t kObliqueWords = 6;
constexpr std::size_t kMaxIndices = std::size_t{1} << (32 - kKindBits);

std::size_t words_of(std::uint32_t word) { return (word & kKindMask) == kOblique ? kObliqueWords : 2; }

}  // namespace

std::size_t KdPart::add_axis(const KdPlane& plane) {
  nodes.push_back(std::bit_cast<std::uint32_t>(plane.at));
  nodes.push_back(static_cast<std::uint32_t>(plane.axis));
  return nodes.size() - 2;
}

std::size_t KdPart::add_oblique(const std::array<float, 4>& words) {
  const std::size_t node = nodes.size();
  nodes.resize(node + kObliqueWords, 0);
  nodes[node] = std::bit_cast<std::uint32_t>(words[3]);
  nodes[node + 1] = kOblique;
  for (std::size_t k = 0; k < 3; ++k) nodes[node + 2 + k] = std::bit_cast<std::uint32_t>(words[k]);
  return node;
}

void KdPart::link(std::size_t node) { nodes[node + 1] |= static_cast<std::uint32_t>(nodes.size() / 2) << kKindBits; }

void KdPart::add_leaf(const std::vector<std::uint32_t>& triangles) {
  nodes.push_back(static_cast<std::uint32_t>(leaves.size()));
  nodes.push_back(kLeaf | static_cast<std::uint32_t>(triangles.size()) << kKindBits);
  leaves.insert(leaves.end(), triangles.begin(), triangles.end());
}

void KdPart::append(const KdPart& other) {
  const auto node = static_cast<std::uint32_t>(nodes.size() / 2), leaf = static_cast<std::uint32_t>(leaves.size());
  const std::size_t from = nodes.size();
  nodes.insert(nodes.end(), other.nodes.begin(), other.nodes.end());
  for (std::size_t i = from; i < nodes.size(); i += words_of(nodes[i + 1])) {
    if ((nodes[i + 1] & kKindMask) == kLeaf)
      nodes[i] += leaf;
    else
      nodes[i + 1] += node << kKindBits;
  }
  leaves.insert(leaves.end(), other.leaves.begin(), other.leaves.end());
}

std::size_t KdPart::node_count() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < nodes.size(); i += words_of(nodes[i + 1])) ++count;
  return count;
}

bool is_hopeless(double cost, std::size_t references, int& bad) {
  const double as_leaf = kKdTriangleCost * static_cast<double>(references);
  if (cost > as_leaf) ++bad;
  return bad > kKdBadSplits || (cost > 4 * as_leaf && references < 16);
}

KdBuilder::KdBuilder(const CellScene& scene, KdSplit split) : scene_(scene), split_(split) {
  // Splits in the middle need many levels to reach a small object in a large scene.
  max_depth_ = split == KdSplit::rotate ? kRotateDepth
                                        : 8 + static_cast<int>(1.3 * std::log2(static_cast<double>(scene.size()) + 1));
}

void KdBuilder::set_below(std::size_t limit, std::function<void(KdPart&, KdTask&&)> below) {
  below_limit_ = limit;
  below_ = std::move(below);
}

void KdBuilder::build(KdPart& part, KdTask&& task) const {
  CellReferences& references = task.references;
  if (below_ && references.size() <= below_limit_) return below_(part, std::move(task));
  std::array<CellReferences, 2> side;
  KdPlane plane;
  if (task.depth < max_depth_ && references.size() > 1)
    plane = split_ == KdSplit::sah ? cheapest_plane(references, task.cell) : halve(task, side);
  int bad = task.bad;
  if (plane.axis == 3 || (split_ == KdSplit::sah && is_hopeless(plane.cost, references.size(), bad)))
    return add_leaf(part, references);

  if (split_ == KdSplit::sah) divide(references, plane, side);
  const std::size_t below = side[0].size(), both = below + side[1].size();
  if (!task.budget.allows(both) || std::min(below, both - below) >= references.size())
    return add_leaf(part, references);
  if (both == 0) return add_leaf(part, {});
  CellReferences().swap(references);
  std::array<KdTask, 2> tasks;
  for (std::size_t i = 0; i < 2; ++i)
    tasks[i] = {std::move(side[i]), task.cell, task.budget.share(i == 0 ? below : both - below, both), task.depth + 1,
                bad};
  tasks[0].cell.hi[plane.axis] = tasks[1].cell.lo[plane.axis] = plane.at;

  const std::size_t node = part.add_axis(plane);
  if (both < kParallelLimit) {
    build(part, std::move(tasks[0]));
    part.link(node);
    build(part, std::move(tasks[1]));
    return;
  }
  std::array<KdPart, 2> parts;
  tbb::parallel_invoke([&] { build(parts[0], std::move(tasks[0])); }, [&] { build(parts[1], std::move(tasks[1])); });
  part.append(parts[0]);
  part.link(node);
  part.append(parts[1]);
}

void KdBuilder::add_leaf(KdPart& part, const CellReferences& references) const {
  std::vector<std::uint32_t> triangles;
  for (const CellReference& each : references) triangles.push_back(scene_.id(each.triangle));
  part.add_leaf(triangles);
}

void KdBuilder::divide(const CellReferences& references, const KdPlane& plane,
                       std::array<CellReferences, 2>& side) const {
  for (std::size_t i = 0; i < 2; ++i) {
    side[i].clear();
    CellReference cut_off;
    for (const CellReference& each : references)
      if (cut(scene_, each, plane.axis, plane.at, i, cut_off)) side[i].push_back(cut_off);
  }
}

/// Splits in the middle across the axis whose turn it is. An axis along which most triangles are in
/// both halves is passed over, because it would spend entries on triangles that another axis
/// separates.
KdPlane KdBuilder::halve(const KdTask& task, std::array<CellReferences, 2>& side) const {
  if (task.references.size() <= kRotateLeaf) return {};
  for (std::size_t turn = 0; turn < 3; ++turn) {
    const std::size_t axis = (static_cast<std::size_t>(task.depth) + turn) % 3;
    const float middle = 0.5F * task.cell.lo[axis] + 0.5F * task.cell.hi[axis];
    if (!(middle > task.cell.lo[axis] && middle < task.cell.hi[axis])) continue;
    const KdPlane plane{0, middle, axis};
    divide(task.references, plane, side);
    const auto both = static_cast<double>(side[0].size() + side[1].size());
    if (both < kRotateMost * static_cast<double>(task.references.size())) return plane;
  }
  return {};
}

Accel KdBuilder::build(const char* name, const char* layout) const {
  Accel accel = scene_.begin(name, layout);
  const Box& box = scene_.box();
  const KdCell cell{{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
  KdPart tree;
  build(tree, {scene_.references(), cell, CellBudget::of(scene_.size()), 0, 0});
  if (tree.nodes.size() / 2 >= kMaxIndices)
    throw InputError("the kd-tree or BSP tree has more nodes than it can number; try --accel bvh");
  accel.nodes.insert(accel.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  accel.leaves.assign(tree.leaves.begin(), tree.leaves.end());
  scene_.finish(accel);
  accel.node_count = tree.node_count();
  accel.stack_size = static_cast<std::uint32_t>(max_depth()) + 1;
  return accel;
}

/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. Depth is at most 8
/// + 1.3 log2(n).
/// throws InputError for more than 2^26 triangles
/// source [Wald, Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N
/// log N)"] for the heuristic; [Pharr, Jakob, Humphreys 2023, PBR, section 7.3.2 of its second
/// edition] for when to stop
Accel build_kdtree(TriangleSoup triangles) {
  return KdBuilder(CellScene(triangles), KdSplit::sah).build("kdtree", "kdtree");
}

/// The same with other splits (KdSplit::rotate). Depth is at most 48.
Accel build_kdtree_rotate(TriangleSoup triangles) {
  return KdBuilder(CellScene(triangles), KdSplit::rotate).build("kdtree-rotate", "kdtree");
}

}  // namespace eikon
