// SPDX-License-Identifier: Apache-2.0
// Fits a tree to triangles that have moved, without building it anew: a sound tree that no builder
// would make.
#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <functional>
#include <optional>

#include "accel/binary_tree.h"

namespace eikon {

inline constexpr std::uint32_t kRefitTaskLimit = 4096;

/// Refits the subtree of `n`. Returns false if one of its triangles has no area.
inline bool refit(BinaryTree& tree, TriangleSoup moved, std::uint32_t n) {
  const auto refit_one = [&](std::uint32_t i) {
    BinaryNode& node = tree.nodes[i];
    Box box;
    if (node.count == 1) {
      const std::uint32_t triangle = tree.triangles[node.first];
      if (is_degenerate(moved, triangle)) return false;
      box = triangle_box(moved, triangle);
    } else {
      box = tree.nodes[left_child(i)].box();
      box.add(tree.nodes[right_child(tree, i)].box());
    }
    node = BinaryNode(box, node.count, node.first);
    return true;
  };
  const std::uint32_t count = tree.nodes[n].count;
  if (count <= kRefitTaskLimit) {
    bool all = true;
    for (std::uint32_t i = n + 2 * count - 1; i-- > n;) all = refit_one(i) && all;  // children come after their parents
    return all;
  }
  bool left = false, right = false;
  tbb::parallel_invoke([&] { left = refit(tree, moved, left_child(n)); },
                       [&] { right = refit(tree, moved, right_child(tree, n)); });
  return left && right && refit_one(n);
}

/// The tree with the boxes of the moved triangles. Hits are those of a tree built anew, to the bit.
/// moved    the triangles that the tree was built over, in the same order
/// returns  nothing if triangles outside the tree have gained area, or triangles in it have lost
///          theirs, so that a new tree must be built
/// Whether a new tree would pay is told by Accel::sah_cost of the new layout.
[[nodiscard]] inline std::optional<BinaryTree> refitted(BinaryTree tree, TriangleSoup moved) {
  const std::size_t with_area = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, moved.size(), 1U << 14), std::size_t{0},
      [&](const auto& part, std::size_t count) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) count += is_degenerate(moved, i) ? 0 : 1;
        return count;
      },
      std::plus<>());
  if (with_area != tree.triangles.size()) return std::nullopt;
  if (!tree.nodes.empty() && !refit(tree, moved, 0)) return std::nullopt;
  return tree;
}

}  // namespace eikon
