// SPDX-License-Identifier: Apache-2.0
// What kd-trees and BSP trees have in common: planes across an axis, and the nodes of kernels/traverse/classic/kdtree.h.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "accel/classic/cells.h"
#include "accel/classic/kdtree.h"

namespace eikon {

// Relative times of a step across an axis and of a test, and what cutting off space gains.
inline constexpr double kKdStepCost = 1, kKdTriangleCost = 3, kKdEmptyGain = 0.8;
inline constexpr int kKdBadSplits = 3;  // splits in a row that seem not to pay, in the hope of one below

struct KdCell {
  std::array<float, 3> lo, hi;
};

/// Across an axis; 3: none.
struct KdPlane {
  double cost = std::numeric_limits<double>::infinity();
  float at = 0;
  std::size_t axis = 3;
};

/// The plane that the surface area heuristic finds best for what is in a cell: from bins or, of few triangles, all planes.
[[nodiscard]] KdPlane cheapest_plane(const CellReferences& references, const KdCell& cell);

/// Nodes and leaves of a part of a tree, numbered from its own beginning. The first child of a node comes next, the other where link()
/// is called.
struct KdPart {
  std::vector<std::uint32_t> nodes, leaves;

  /// returns the node, for link()
  std::size_t add_axis(const KdPlane& plane);
  /// words: n, d of n (x - c) = d
  std::size_t add_oblique(const std::array<float, 4>& words);
  void link(std::size_t node);
  void add_leaf(const std::vector<std::uint32_t>& triangles);
  void append(const KdPart& other);
  [[nodiscard]] std::size_t node_count() const;
};

/// What is still to be built of a tree. bad: splits above in a row that seem not to pay.
struct KdTask {
  CellReferences references;
  KdCell cell;
  CellBudget budget;
  int depth = 0, bad = 0;
};

/// Whether a split of this cost is given up for a leaf; counts it in `bad`.
[[nodiscard]] bool is_hopeless(double cost, std::size_t references, int& bad);

class KdBuilder {
 public:
  KdBuilder(const CellScene& scene, KdSplit split);
  /// Parts of at most `limit` references are built by `below` instead.
  void set_below(std::size_t limit, std::function<void(KdPart&, KdTask&&)> below);
  [[nodiscard]] int max_depth() const { return max_depth_; }
  void build(KdPart& part, KdTask&& task) const;

  /// The whole tree as the traversal reads it.
  /// throws InputError if it has more nodes than can be numbered
  [[nodiscard]] Accel build(const char* name, const char* layout) const;

 private:
  [[nodiscard]] KdPlane halve(const KdTask& task, std::array<CellReferences, 2>& side) const;
  void divide(const CellReferences& references, const KdPlane& plane, std::array<CellReferences, 2>& side) const;
  void add_leaf(KdPart& part, const CellReferences& references) const;

  const CellScene& scene_;
  KdSplit split_;
  int max_depth_ = 0;
  std::size_t below_limit_ = 0;
  std::function<void(KdPart&, KdTask&&)> below_;
};

}  // namespace eikon
