// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>

#include "accel/layouts/layouts.h"

namespace eikon {
namespace {

constexpr std::uint32_t kLeafLimit = 4;
constexpr std::size_t kBvh2NodeWords = 16;
constexpr float kNodeCost = 1.0F, kTriangleCost = 0.7F;  // two boxes, one triangle

class Bvh2Emitter {
 public:
  Bvh2Emitter(const BinaryTree& tree, Accel& accel) : tree_(tree), accel_(accel), leaf_(tree.nodes.size()) {
    std::vector<float> cost(tree.nodes.size());
    for (auto n = static_cast<std::uint32_t>(tree.nodes.size()); n-- > 0;) {
      const std::uint32_t count = tree.nodes[n].count;
      const float area = tree.nodes[n].box().half_area();
      const float as_leaf = area * kTriangleCost * static_cast<float>(count);
      const float as_node = count == 1 ? as_leaf : area * kNodeCost + cost[left_child(n)] + cost[right_child(tree, n)];
      leaf_[n] = count == 1 || (count <= kLeafLimit && as_leaf <= as_node && !tree.has_instance(tree.nodes[n]));
      cost[n] = leaf_[n] ? as_leaf : as_node;
    }
    const float root = tree.nodes[0].box().half_area();
    accel_.sah_cost = root > 0 ? static_cast<double>(cost[0] / root) : 0.0;
    accel_.stack_size = 1 + emit(0, 0);
  }

 private:
  /// Appends node `n` and all nodes below it. Returns the most entries of the stack below this
  /// node.
  std::uint32_t emit(std::uint32_t n, std::uint32_t first) {
    const std::size_t to = accel_.nodes.size();
    accel_.nodes.resize(to + kBvh2NodeWords, 0);
    if (leaf_[n]) {  // the root is one leaf, so its other child is empty
      write_child(to, 0, tree_.nodes[n].box(), leaf_word(n, first));
      write_child(to, 1, Box{}, kLeafBit);
      return 0;
    }
    const std::array<std::uint32_t, 2> child{left_child(n), right_child(tree_, n)};
    const std::array<std::uint32_t, 2> begin{first, first + tree_.nodes[child[0]].count};
    std::uint32_t below = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      const bool leaf = leaf_[child[side]];
      const auto index = static_cast<std::uint32_t>(accel_.nodes.size() / kBvh2NodeWords);
      write_child(to, side, tree_.nodes[child[side]].box(), leaf ? leaf_word(child[side], begin[side]) : index);
      if (!leaf) below = std::max(below, emit(child[side], begin[side]));
    }
    return below + 1;
  }

  [[nodiscard]] std::uint32_t leaf_word(std::uint32_t n, std::uint32_t first) const {
    if (tree_.has_instance(tree_.nodes[n])) return tree_.instance_word(tree_.nodes[n]);
    return kLeafBit | (tree_.nodes[n].count - 1) << kCountShift | first;
  }

  void write_child(std::size_t node, std::size_t side, const Box& box, std::uint32_t word) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      accel_.nodes[node + 6 * side + axis] = std::bit_cast<std::uint32_t>(float{box.lo[axis]});
      accel_.nodes[node + 6 * side + 3 + axis] = std::bit_cast<std::uint32_t>(float{box.hi[axis]});
    }
    accel_.nodes[node + 12 + side] = word;
  }

  const BinaryTree& tree_;
  Accel& accel_;
  std::vector<bool> leaf_;
};

}  // namespace

Accel layout_bvh2(const BinaryTree& tree) {
  Accel accel{.name = "bvh", .layout = "bvh2"};
  if (tree.nodes.empty()) {
    // A single node with two empty boxes.
    accel.nodes.resize(kBvh2NodeWords, 0);
    for (std::size_t i = 0; i < 12; ++i) accel.nodes[i] = i % 6 < 3 ? 0x7f800000U : 0xff800000U;
    accel.nodes[12] = accel.nodes[13] = kLeafBit;
    accel.leaves.resize(1, 0);
    accel.node_count = 1;
    return accel;
  }
  const Bvh2Emitter emitter(tree, accel);
  accel.leaves.assign(tree.triangles.begin(), tree.triangles.end());
  accel.node_count = accel.nodes.size() / kBvh2NodeWords;
  return accel;
}

}  // namespace eikon
