// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <numeric>

#include "accel/collapse.h"
#include "accel/layouts.h"

namespace eikon {
namespace {

constexpr std::uint32_t kBlock = 8;  // triangles, whatever the width of a node
constexpr std::size_t kBlockWords = 10 * kBlock;
constexpr std::uint32_t kLeafBit = 0x80000000U;
// In units of one step: all boxes of a node, or 8 triangles, are tested at once.
constexpr CollapseCosts kCosts{.leaf_limit = kBlock, .node = 1.0F, .leaf = 1.0F, .triangle = 0.0F};

struct Block {
  std::uint32_t first = 0, count = 0;  // into BinaryTree::triangles
};

template <std::uint32_t kWidth>
class Emitter {
  static constexpr std::size_t kNodeWords = 8 * kWidth;
  static constexpr std::uint32_t kOrderBits = std::bit_width(kWidth - 1);

 public:
  Emitter(const BinaryTree& tree, Accel& accel) : tree_(tree), collapse_(tree, kCosts), accel_(accel) {
    accel_.nodes.resize(kNodeWords);
    accel_.stack_size = 1 + emit(0, 0);
    const float root = tree.nodes[0].box().half_area();
    accel_.sah_cost = root > 0 ? static_cast<double>(collapse_.cost() / root) : 0.0;
  }
  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }

 private:
  /// Writes wide node `to` and all below. returns how many entries the stack can hold below this node.
  std::uint32_t emit(std::uint32_t binary, std::size_t to) {
    const std::vector<WideChild> children = collapse_.children(binary);
    std::array<std::uint32_t, kWidth> words{};
    std::array<Float4, kWidth> centers{};
    std::uint32_t inner = 0;
    for (std::size_t i = 0; i < kWidth; ++i) {
      Box box;  // empty: never hit
      if (i < children.size()) {
        const std::uint32_t child = children[i].binary;
        box = tree_.nodes[child].box();
        centers[i] = box.lo + box.hi;
        if (children[i].leaf) {
          words[i] = kLeafBit | static_cast<std::uint32_t>(blocks_.size());
          blocks_.push_back({tree_.nodes[child].first, tree_.nodes[child].count});
        } else {
          words[i] = static_cast<std::uint32_t>(accel_.nodes.size() / kNodeWords) + inner++;
        }
      }
      std::uint32_t* node = accel_.nodes.data() + to * kNodeWords;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node[2 * kWidth * axis + i] = std::bit_cast<std::uint32_t>(float{box.lo[axis]});
        node[(2 * axis + 1) * kWidth + i] = std::bit_cast<std::uint32_t>(float{box.hi[axis]});
      }
      node[6 * kWidth + i] = words[i];
    }
    store_orders(accel_.nodes.data() + to * kNodeWords + 7 * kWidth, centers, children.size());
    accel_.nodes.resize(accel_.nodes.size() + inner * kNodeWords);
    std::uint32_t below = 0;
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (!children[i].leaf) below = std::max(below, emit(children[i].binary, words[i]));
    }
    return below + static_cast<std::uint32_t>(children.size()) - 1;
  }

  /// For each octant of directions the children from far to near, by their centres; missing children come first.
  static void store_orders(std::uint32_t* words, const std::array<Float4, kWidth>& centers, std::size_t count) {
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const auto depth = [&](std::uint32_t i) {
        if (i >= count) return std::numeric_limits<float>::infinity();
        float sum = 0;
        for (int axis = 0; axis < 3; ++axis)
          sum += (octant >> axis & 1U) != 0 ? -centers[i][axis] : float{centers[i][axis]};
        return sum;
      };
      std::array<std::uint32_t, kWidth> order{};
      std::iota(order.begin(), order.end(), 0U);
      std::stable_sort(order.begin(), order.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return depth(a) > depth(b); });
      for (std::size_t i = 0; i < kWidth; ++i) words[i] |= order[i] << kOrderBits * octant;
    }
  }

  const BinaryTree& tree_;
  Collapse<kWidth> collapse_;
  Accel& accel_;
  std::vector<Block> blocks_;
};

template <std::uint32_t kWidth>
Accel layout(const char* name, const BinaryTree& tree, TriangleSoup triangles) {
  Accel accel;
  accel.name = "bvh";
  accel.layout = name;
  if (tree.nodes.empty()) {
    // One node without children: lo = +inf, hi = -inf in every slot.
    accel.nodes.resize(8 * kWidth, 0);
    for (std::size_t i = 0; i < 6 * kWidth; ++i) accel.nodes[i] = (i & kWidth) != 0 ? 0xff800000U : 0x7f800000U;
    accel.leaves.resize(kBlockWords, 0);
    accel.node_count = 1;
    return accel;
  }
  const Emitter<kWidth> emitter(tree, accel);
  const auto& blocks = emitter.blocks();
  accel.node_count = accel.nodes.size() / (8 * kWidth);
  accel.leaves.resize(blocks.size() * kBlockWords);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    std::uint32_t* words = accel.leaves.data() + b * kBlockWords;
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      const bool used = i < blocks[b].count;
      const std::uint32_t triangle = used ? tree.triangles[blocks[b].first + i] : 0;
      for (std::size_t k = 0; k < 9; ++k) {
        // An unused lane is NaN: no comparison of the triangle test holds for it.
        words[kBlock * k + i] = used ? std::bit_cast<std::uint32_t>(triangles.corners(triangle)[k]) : 0x7fc00000U;
      }
      words[9 * kBlock + i] = used ? triangle : 0xffffffffU;
    }
  });
  return accel;
}

}  // namespace

Accel layout_bvh8(const BinaryTree& tree, TriangleSoup triangles) { return layout<8>("bvh8", tree, triangles); }
Accel layout_bvh16(const BinaryTree& tree, TriangleSoup triangles) { return layout<16>("bvh16", tree, triangles); }

}  // namespace eikon
