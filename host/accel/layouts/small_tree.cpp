// SPDX-License-Identifier: Apache-2.0
#include "accel/layouts/small_tree.h"

#include <limits>

namespace eikon {

SmallTree::SmallTree(const Reference* references, std::size_t count, std::uint32_t* triangles)
    : references_(references), count_(count), triangles_(triangles) {
  // Counts the rank of each reference along the three axes at once. Equals keep their order.
  std::array<Float4, kLimit> centroids;
  std::array<Int4, kLimit> rank;
  for (std::size_t i = 0; i < count; ++i) {
    const Float4 c = centroid2(references[i]);
    Int4 below{};
    for (std::size_t j = 0; j < i; ++j) {
      const Int4 lower = c < centroids[j];  // -1 where true
      rank[j] -= lower;
      below += 1 + lower;
    }
    centroids[i] = c;
    rank[i] = below;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      order_[axis][static_cast<std::size_t>(rank[i][axis])] = static_cast<std::uint8_t>(i);
    }
  }
}

void SmallTree::build(BinaryNode* nodes, std::size_t begin, std::size_t end, const Box& box) {
  const std::size_t count = end - begin;
  *nodes = BinaryNode(box, count, first_ + begin);
  if (count == 1) {
    triangles_[first_ + begin] = references_[order_[0][begin]].triangle();
    return;
  }
  std::size_t axis = 0, middle = begin + 1;
  if (count > 2) {
    const auto add = [&](Box3& boxes, std::size_t i) {
      for (std::size_t a = 0; a < 3; ++a) boxes[a].add(references_[order_[a][i]].box());
    };
    std::array<Float4, kLimit> right_cost;
    Box3 boxes;
    Int4 n{};
    for (std::size_t i = end - 1; i > begin; --i) {
      add(boxes, i);
      right_cost[i] = half_areas(boxes) * count_costs(++n);
    }
    boxes = Box3{};
    n = Int4{};
    Float4 best_cost = splat4(std::numeric_limits<float>::infinity());
    Int4 best_middle = Int4{} + static_cast<std::int32_t>(begin + count / 2);
    for (std::size_t i = begin + 1; i < end; ++i) {
      add(boxes, i - 1);
      const Float4 cost = half_areas(boxes) * count_costs(++n) + right_cost[i];
      const Int4 better = cost < best_cost;
      best_cost = better ? cost : best_cost;
      best_middle = better ? Int4{} + static_cast<std::int32_t>(i) : best_middle;
    }
    for (std::size_t a = 1; a < 3; ++a) axis = best_cost[a] < best_cost[axis] ? a : axis;
    middle = static_cast<std::size_t>(best_middle[axis]);
  }
  Box left, right;
  for (std::size_t i = begin; i < middle; ++i) left.add(references_[order_[axis][i]].box());
  for (std::size_t i = middle; i < end; ++i) right.add(references_[order_[axis][i]].box());
  divide(begin, end, axis, middle);
  build(nodes + 1, begin, middle, left);
  build(nodes + 2 * (middle - begin), middle, end, right);
}

/// References before `middle` in the order along `axis` come first in the other orders too, which
/// stay sorted on both sides.
void SmallTree::divide(std::size_t begin, std::size_t end, std::size_t axis, std::size_t middle) {
  std::uint32_t is_left = 0;
  for (std::size_t i = begin; i < middle; ++i) is_left |= 1U << order_[axis][i];
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == axis) continue;
    Order right;
    std::size_t lefts = begin, rights = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint8_t each = order_[a][i];
      const std::uint32_t left = is_left >> each & 1U;
      order_[a][lefts] = right[rights] = each;
      lefts += left;
      rights += 1 - left;
    }
    for (std::size_t i = 0; i < rights; ++i) order_[a][lefts + i] = right[i];
  }
}

}  // namespace eikon
