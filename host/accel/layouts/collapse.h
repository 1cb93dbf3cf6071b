// SPDX-License-Identifier: Apache-2.0
// Chooses the nodes of a binary tree that become the nodes and leaves of a wide one, with the least
// SAH cost of all ways to collapse it [Ylitie, Karras, Laine 2017, "Efficient incoherent ray
// traversal on GPUs through compressed wide BVHs", section 3.1].
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "accel/binary_tree.h"

namespace eikon {

/// Costs in any unit: of a node, of a leaf, and of each triangle in a leaf. Leaves hold at most
/// `leaf_limit` triangles.
struct CollapseCosts {
  std::uint32_t leaf_limit = 8;
  float node = 1.0F, leaf = 1.0F, triangle = 0.0F;
};

struct WideChild {
  std::uint32_t binary = 0;  // its root in the binary tree
  bool leaf = false;
};

/// cost(n, k): the least cost of covering the subtree of binary node n by at most k roots, each a
/// wide node or a leaf. kWidth: children of a node, 4, 8 or 16
template <std::uint32_t kWidth>
class Collapse {
 public:
  /// `tree` is not empty, and outlives this.
  explicit Collapse(const BinaryTree& tree, const CollapseCosts& costs = {});

  [[nodiscard]] float cost() const { return cost(0, 1); }
  [[nodiscard]] bool is_leaf(std::uint32_t n) const { return leaf_cost(n) <= cost(n, 1); }

  /// The children of the wide node made of binary node n, smallest first: an any-hit ray tries the
  /// last, likeliest, first.
  [[nodiscard]] std::vector<WideChild> children(std::uint32_t n) const;

 private:
  static constexpr float kInstanceCost = 4.0F;  // of taking a ray into an instance, in steps
  using Row = std::array<float, kWidth>;     // entry k - 1: cost(n, k); the last one is not used
  struct Division {
    float cost;
    std::uint32_t left = 0;  // roots that the left child gets
  };

  [[nodiscard]] float area(std::uint32_t n) const { return tree_.nodes[n].box().half_area(); }
  [[nodiscard]] float cost(std::uint32_t n, std::uint32_t k) const { return row(n)[k - 1]; }
  [[nodiscard]] float leaf_cost(std::uint32_t n) const {
    const std::uint32_t count = tree_.nodes[n].count;
    if (tree_.has_instance(tree_.nodes[n]))
      return count == 1 ? area(n) * kInstanceCost : std::numeric_limits<float>::infinity();
    return count <= unit_.leaf_limit ? area(n) * (unit_.leaf + unit_.triangle * static_cast<float>(count))
                                     : std::numeric_limits<float>::infinity();
  }
  [[nodiscard]] Row row(std::uint32_t n) const {
    const BinaryNode& node = tree_.nodes[n];
    if (node.count > 1) return rows_[n - node.first];
    Row row;
    row.fill(leaf_cost(n));
    return row;
  }
  [[nodiscard]] Division divide(std::uint32_t n, std::uint32_t k) const;
  void solve(std::uint32_t n);
  void solve_one(std::uint32_t n);
  void collect(std::uint32_t n, std::uint32_t k, std::vector<WideChild>& list) const;

  const BinaryTree& tree_;
  CollapseCosts unit_;
  BigVector<Row> rows_;  // of inner nodes
};

extern template class Collapse<4>;
extern template class Collapse<8>;
extern template class Collapse<16>;

}  // namespace eikon
