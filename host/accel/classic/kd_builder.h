// SPDX-License-Identifier: Apache-2.0
// The common part of kd-trees and BSP trees: planes across an axis, and the nodes of
// kernels/traverse/classic/kdtree.h.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "accel/classic/cells.h"

namespace eikon {

enum class KdSplit {
  sah,     // the best plane by the surface area heuristic, of bins, or of all planes if triangles are few
  rotate,  // the middle of the cell, across each axis in turn, until few triangles are left
};

// Relative times of a step across an axis and of a triangle test; factor of the cost if a side is
// empty.
inline constexpr double kKdStepCost = 1, kKdTriangleCost = 3, kKdEmptyGain = 0.8;
inline constexpr int kKdBadSplits = 3;  // splits in a row that may seem not to pay, because one below them may

struct KdCell {
  std::array<float, 3> lo, hi;
};

/// A plane across an axis; axis 3 means no plane.
struct KdPlane {
  double cost = std::numeric_limits<double>::infinity();
  float at = 0;
  std::size_t axis = 3;
};

/// The best plane of a cell by the surface area heuristic, of bins, or of all planes if triangles
/// are few.
[[nodiscard]] KdPlane cheapest_plane(const CellReferences& references, const KdCell& cell);

/// Nodes and leaves of a part of a tree, numbered from its own beginning. The first child of a node
/// comes next, the other one comes where link() is called.
struct KdPart {
  std::vector<std::uint32_t> nodes, leaves;

  /// Returns the node, for link().
  std::size_t add_axis(const KdPlane& plane);
  /// words: n and d of the plane n (x - c) = d
  std::size_t add_oblique(const std::array<float, 4>& words);
  void link(std::size_t node);
  void add_leaf(const std::vector<std::uint32_t>& triangles);
  void append(const KdPart& other);
  [[nodiscard]] std::size_t node_count() const;
};

/// A part of a tree that is still to be built. bad: number of splits in a row above it that seem
/// not to pay
struct KdTask {
  CellReferences references;
  KdCell cell;
  CellBudget budget;
  int depth = 0, bad = 0;
};

/// True if a leaf is better than a split of this cost. Counts the split in `bad` if it seems not to
/// pay.
[[nodiscard]] bool is_hopeless(double cost, std::size_t references, int& bad);

class KdBuilder {
 public:
  KdBuilder(const CellScene& scene, KdSplit split);
  /// Lets `below` build parts of at most `limit` references.
  void set_below(std::size_t limit, std::function<void(KdPart&, KdTask&&)> below);
  [[nodiscard]] int max_depth() const { return max_depth_; }
  void build(KdPart& part, KdTask&& task) const;

  /// Builds the whole tree for the traversal.
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
