// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/builders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "accel/classic/cells.h"

namespace eikon {
namespace {

constexpr std::size_t kLeafTriangles = 6, kOctreeParallelLimit = 4096, kNodeWords = 12;
constexpr int kMaxDepth = 16;

/// A part of the tree for the traversal. `nodes` and `leaves` are numbered from its own beginning.
struct Part {
  std::vector<std::uint32_t> nodes, leaves;
  std::uint32_t root = 0;  // its child word

  /// Returns the child word of `other`'s root within this.
  std::uint32_t append(const Part& other) {
    const auto node = static_cast<std::uint32_t>(nodes.size() / kNodeWords),
               leaf = static_cast<std::uint32_t>(leaves.size());
    const auto moved = [&](std::uint32_t word) { return word + ((word & kLeafBit) != 0 ? leaf : node); };
    for (std::size_t i = 0; i < other.nodes.size(); ++i) {
      const std::size_t word = i % kNodeWords;
      const bool child = word >= 3 && word < 11 && other.nodes[i] != 0;
      nodes.push_back(child ? moved(other.nodes[i]) : other.nodes[i]);
    }
    leaves.insert(leaves.end(), other.leaves.begin(), other.leaves.end());
    return other.nodes.empty() && other.leaves.empty() ? 0 : moved(other.root);
  }
};

struct Cell {
  std::array<float, 3> lo, hi;
};

class OctreeBuilder {
 public:
  explicit OctreeBuilder(const CellScene& scene) : scene_(scene) {}

  /// references: at least one, except for the root
  [[nodiscard]] Part build(CellReferences&& references, const Cell& cell, CellBudget budget, int depth) const {
    Part part;
    std::array<float, 3> middle{};
    // The root is always inner.
    bool divisible = depth < kMaxDepth && (references.size() > kLeafTriangles || depth == 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      middle[axis] = 0.5F * cell.lo[axis] + 0.5F * cell.hi[axis];
      divisible = divisible && (depth == 0 || (middle[axis] > cell.lo[axis] && middle[axis] < cell.hi[axis]));
    }
    if (!divisible) return leaf(references);
    std::array<CellReferences, 8> children;
    std::size_t all = 0;
    for (const CellReference& each : references) divide(each, middle, children);
    for (const CellReferences& each : children) all += each.size();
    // Dividing gains nothing if most triangles are in most children, such as around a corner that
    // many share.
    if (depth > 0 && (!budget.allows(all) || all >= 6 * references.size())) return leaf(references);

    const std::size_t count = references.size();
    CellReferences().swap(references);
    std::array<Part, 8> parts;
    const auto descend = [&](std::size_t i) {
      if (children[i].empty()) return;
      Cell octant = cell;
      for (std::size_t axis = 0; axis < 3; ++axis) ((i >> axis & 1U) != 0 ? octant.lo : octant.hi)[axis] = middle[axis];
      const CellBudget share = budget.share(children[i].size(), all);
      parts[i] = build(std::move(children[i]), octant, share, depth + 1);
    };
    if (count >= kOctreeParallelLimit)
      tbb::parallel_for(std::size_t{0}, std::size_t{8}, descend);
    else
      for (std::size_t i = 0; i < 8; ++i) descend(i);

    part.nodes.resize(kNodeWords, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) part.nodes[axis] = std::bit_cast<std::uint32_t>(middle[axis]);
    for (std::size_t i = 0; i < 8; ++i) {
      const std::uint32_t word = part.append(parts[i]);
      part.nodes[3 + i] = word;
      parts[i] = Part();
    }
    return part;
  }

 private:
  [[nodiscard]] Part leaf(const CellReferences& references) const {
    Part part;
    part.root = kLeafBit;
    part.leaves.push_back(static_cast<std::uint32_t>(references.size()));
    for (const CellReference& each : references) part.leaves.push_back(scene_.id(each.triangle));
    return part;
  }

  void divide(const CellReference& whole, const std::array<float, 3>& middle,
              std::array<CellReferences, 8>& children) const {
    CellReference x, y, z;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!cut(scene_, whole, 0, middle[0], i, x)) continue;
      for (std::size_t j = 0; j < 2; ++j) {
        if (!cut(scene_, x, 1, middle[1], j, y)) continue;
        for (std::size_t k = 0; k < 2; ++k)
          if (cut(scene_, y, 2, middle[2], k, z)) children[i + 2 * j + 4 * k].push_back(z);
      }
    }
  }

  const CellScene& scene_;
};

}  // namespace

/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. There are at most
/// 16 levels. Leaves have up to 6 triangles, and more where dividing them gains nothing.
/// throws InputError for more than 2^26 triangles
/// source [Glassner 1984, "Space subdivision for fast ray tracing"]
Accel build_octree(TriangleSoup triangles) {
  const CellScene scene(triangles);
  Accel accel = scene.begin("octree", "octree");
  // The root is a cube around the scene, cut off at the largest float; then it is merely no cube.
  Cell cube{};
  float half = 0;
  const Box& box = scene.box();
  for (std::size_t axis = 0; axis < 3; ++axis) half = std::max(half, 0.5F * box.hi[axis] - 0.5F * box.lo[axis]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float middle = 0.5F * box.lo[axis] + 0.5F * box.hi[axis];
    constexpr float most = std::numeric_limits<float>::max();
    cube.lo[axis] = std::max(std::min(middle - half, float{box.lo[axis]}), -most);
    cube.hi[axis] = std::min(std::max(middle + half, float{box.hi[axis]}), most);
  }
  const Part tree = OctreeBuilder(scene).build(scene.references(), cube, CellBudget::of(scene.size()), 0);
  accel.nodes.insert(accel.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  accel.leaves.assign(tree.leaves.begin(), tree.leaves.end());
  scene.finish(accel);
  accel.node_count = tree.nodes.size() / kNodeWords;
  accel.stack_size = 7 * kMaxDepth + 1;
  return accel;
}

}  // namespace eikon
