// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "accel/layouts/collapse.h"
#include "accel/layouts/layouts.h"

namespace eikon {
namespace {

// Costs in steps. One step tests one ray with all boxes of a node, or with 8 triangles, at once.
constexpr CollapseCosts kWideCosts{.leaf_limit = kBlock, .node = 1.0F, .leaf = 1.0F, .triangle = 0.0F};
// If the rays of all lanes go together, each triangle takes a test, and so does each box that the
// rays meet (measured).
constexpr CollapseCosts kCostsTogether{.leaf_limit = kBlock, .node = 1.0F, .leaf = 0.7F, .triangle = 0.3F};
// Most triangles and shapes for which rays go together. It pays for 38 and not for 444 (measured);
// this is a guess in between.
constexpr std::size_t kTogether = 100;

bool go_together(const BinaryTree& tree) { return !tree.is_part && tree.triangles.size() <= kTogether; }

struct Block {
  std::uint32_t first = 0, count = 0;  // into BinaryTree::triangles
};

template <std::uint32_t kWidth>
class WideEmitter {
  static constexpr std::size_t kNodeWords = 8 * kWidth;
  static constexpr std::uint32_t kOrderBits = std::bit_width(kWidth - 1);

 public:
  WideEmitter(const BinaryTree& tree, Accel& accel)
      : tree_(tree), collapse_(tree, go_together(tree) ? kCostsTogether : kWideCosts), accel_(accel) {
    accel_.together = go_together(tree);
    nodes_.emplace_back();
    accel_.stack_size = 1 + number(0, 0);
    accel_.nodes.resize(nodes_.size() * kNodeWords);
    tbb::parallel_for(std::size_t{0}, nodes_.size(), [&](std::size_t i) { write(nodes_[i], i); });
    const float root = tree.nodes[0].box().half_area();
    accel_.sah_cost = root > 0 ? static_cast<double>(collapse_.cost() / root) : 0.0;
  }
  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }

 private:
  /// First of a wide node's children in `children_`, and the numbers of the first node and block
  /// among them.
  struct WideNode {
    std::size_t first = 0;
    std::uint32_t count = 0, first_node = 0, first_block = 0;
  };

  /// Numbers everything below wide node `to`, which is made of a binary node. Returns the most
  /// entries of the stack below it.
  std::uint32_t number(std::uint32_t binary, std::size_t to) {
    const std::vector<WideChild> children = collapse_.children(binary);
    const auto first_node = static_cast<std::uint32_t>(nodes_.size());
    nodes_[to] = {children_.size(), static_cast<std::uint32_t>(children.size()), first_node,
                  static_cast<std::uint32_t>(blocks_.size())};
    children_.insert(children_.end(), children.begin(), children.end());
    std::uint32_t inner = 0;
    for (const WideChild& child : children) {
      if (child.leaf && tree_.has_instance(tree_.nodes[child.binary])) continue;
      if (child.leaf)
        blocks_.push_back({tree_.nodes[child.binary].first, tree_.nodes[child.binary].count});
      else
        ++inner;
    }
    nodes_.resize(nodes_.size() + inner);
    std::uint32_t below = 0, next = first_node;
    for (const WideChild& child : children) {
      if (!child.leaf) below = std::max(below, number(child.binary, next++));
    }
    return below + nodes_[to].count - 1;
  }

  void write(const WideNode& wide, std::size_t to) {
    std::array<Float4, kWidth> centers{};
    std::uint32_t next_node = wide.first_node, next_block = wide.first_block;
    std::uint32_t* node = accel_.nodes.data() + to * kNodeWords;
    for (std::size_t i = 0; i < kWidth; ++i) {
      Box box;  // empty: never hit
      std::uint32_t word = 0;
      if (i < wide.count) {
        const WideChild& child = children_[wide.first + i];
        box = tree_.nodes[child.binary].box();
        centers[i] = box.lo + box.hi;
        word = !child.leaf                                     ? next_node++
               : tree_.has_instance(tree_.nodes[child.binary]) ? tree_.instance_word(tree_.nodes[child.binary])
                                                               : kLeafBit | next_block++;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node[2 * kWidth * axis + i] = std::bit_cast<std::uint32_t>(float{box.lo[axis]});
        node[(2 * axis + 1) * kWidth + i] = std::bit_cast<std::uint32_t>(float{box.hi[axis]});
      }
      node[6 * kWidth + i] = word;
    }
    store_orders(node + 7 * kWidth, centers, wide.count);
  }

  /// Orders the children from far to near by their centres, for each octant of directions. Missing
  /// children come first.
  static void store_orders(std::uint32_t* words, const std::array<Float4, kWidth>& centers, std::uint32_t count) {
    const std::uint32_t missing = kWidth - count;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      std::array<float, kWidth> depth{};
      std::array<std::uint32_t, kWidth> order{};
      for (std::uint32_t i = 0; i < count; ++i) {
        float own = 0;
        for (int axis = 0; axis < 3; ++axis)
          own += (octant >> axis & 1U) != 0 ? -centers[i][axis] : float{centers[i][axis]};
        std::uint32_t at = i;
        for (; at > 0 && depth[at - 1] < own; --at) {
          depth[at] = depth[at - 1];
          order[at] = order[at - 1];
        }
        depth[at] = own;
        order[at] = i;
      }
      for (std::uint32_t i = 0; i < kWidth; ++i)
        words[i] |= (i < missing ? count + i : order[i - missing]) << kOrderBits * octant;
    }
  }

  const BinaryTree& tree_;
  Collapse<kWidth> collapse_;
  Accel& accel_;
  std::vector<WideNode> nodes_;
  std::vector<WideChild> children_;
  std::vector<Block> blocks_;
};

template <std::uint32_t kWidth>
Accel layout(const char* name, const BinaryTree& tree, TriangleSoup triangles) {
  Accel accel{.name = "bvh", .layout = name};
  if (tree.nodes.empty()) {
    // A node without children has lo = +inf and hi = -inf in every slot.
    accel.nodes.resize(8 * kWidth, 0);
    for (std::size_t i = 0; i < 6 * kWidth; ++i) accel.nodes[i] = (i & kWidth) != 0 ? 0xff800000U : 0x7f800000U;
    accel.leaves.resize(kBlockWords, EK_NO_HIT);
    accel.node_count = 1;
    return accel;
  }
  const WideEmitter<kWidth> emitter(tree, accel);
  const auto& blocks = emitter.blocks();
  accel.node_count = accel.nodes.size() / (8 * kWidth);
  accel.leaves.resize(blocks.size() * std::size_t{kBlockWords});
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    std::uint32_t* words = accel.leaves.data() + b * std::size_t{kBlockWords};
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      const bool used = i < blocks[b].count;
      const std::uint32_t triangle = used ? tree.triangles[blocks[b].first + i] : 0;
      for (std::size_t k = 0; k < 9; ++k) {
        // An unused lane is NaN: no comparison of the triangle test holds for it.
        words[kBlock * k + i] = used ? std::bit_cast<std::uint32_t>(triangles.corners(triangle)[k]) : 0x7fc00000U;
      }
      words[kBlockTriangles + i] = used ? triangle : EK_NO_HIT;
    }
  });
  return accel;
}

}  // namespace

Accel layout_bvh8(const BinaryTree& tree, TriangleSoup triangles) { return layout<8>("bvh8", tree, triangles); }
Accel layout_bvh16(const BinaryTree& tree, TriangleSoup triangles) { return layout<16>("bvh16", tree, triangles); }

}  // namespace eikon
