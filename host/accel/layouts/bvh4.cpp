// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "accel/layouts/collapse.h"
#include "accel/layouts/layouts.h"
#include "accel/layouts/quantised.h"

namespace eikon {
namespace {

constexpr std::size_t kPlaneWord = 4, kChildWord = 12;
// The cost of a node's four boxes relative to a triangle is between those of bvh2 and cwbvh.
constexpr CollapseCosts kBvh4Costs{.leaf_limit = 4, .node = 1.0F, .leaf = 0.0F, .triangle = 0.5F};

class Bvh4Emitter {
 public:
  static constexpr std::size_t kNodeWords = 16;
  Bvh4Emitter(const BinaryTree& tree, Accel& accel) : tree_(tree), collapse_(tree, kBvh4Costs), accel_(accel) {
    accel_.leaves.assign(tree.triangles.begin(), tree.triangles.end());
  }
  [[nodiscard]] float cost() const { return collapse_.cost(); }

  /// Writes node `to` and all nodes below it. Returns the most entries of the stack below this
  /// node.
  std::uint32_t emit(std::uint32_t binary, std::size_t to) {
    const std::vector<WideChild> children = collapse_.children(binary);
    Box around;
    for (const WideChild& child : children) around.add(tree_.nodes[child.binary].box());
    const QuantisedFrame frame(around);
    std::uint32_t* node = accel_.nodes.data() + to * kNodeWords;
    std::ranges::copy(frame.words((1U << children.size()) - 1), node);
    auto next = static_cast<std::uint32_t>(accel_.nodes.size() / kNodeWords);
    for (std::uint32_t i = 0; i < children.size(); ++i) {
      const std::uint32_t child = children[i].binary;
      const QuantisedBox box = frame.quantise(tree_.nodes[child].box());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node[kPlaneWord + 2 * axis] |= std::uint32_t{box.lo[axis]} << 8 * i;
        node[kPlaneWord + 2 * axis + 1] |= std::uint32_t{box.hi[axis]} << 8 * i;
      }
      node[kChildWord + i] = children[i].leaf
                                 ? kLeafBit | (tree_.nodes[child].count - 1) << kCountShift | tree_.nodes[child].first
                                 : next++;
    }
    const std::uint32_t own = static_cast<std::uint32_t>(accel_.nodes.size() / kNodeWords);
    accel_.nodes.resize(std::size_t{next} * kNodeWords);  // `node` is invalid from here on
    std::uint32_t below = 0, inner = own;
    for (std::size_t i = 0; i < children.size(); ++i)
      if (!children[i].leaf) below = std::max(below, emit(children[i].binary, inner++));
    return below + static_cast<std::uint32_t>(children.size()) - 1;
  }

 private:
  const BinaryTree& tree_;
  Collapse<4> collapse_;
  Accel& accel_;
};

}  // namespace

Accel layout_bvh4(const BinaryTree& tree) { return quantised_accel<Bvh4Emitter>("bvh4", tree); }

}  // namespace eikon
