// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <utility>

#include "accel/layouts/collapse.h"
#include "accel/layouts/layouts.h"
#include "accel/layouts/quantised.h"

namespace eikon {
namespace {

constexpr std::uint32_t kCwbvhWidth = 8;
constexpr std::size_t kKindWord = 6, kCwbvhPlaneWord = 8;
// A child has at most three triangles, so that 24 bits name those of a node. The costs are the
// paper's.
constexpr CollapseCosts kCwbvhCosts{.leaf_limit = 3, .node = 1.0F, .leaf = 0.0F, .triangle = 0.3F};

/// Assigns children to slots; -1: none. Rays of octant k should meet the child in slot k first, so
/// this minimises the sum over children of their offset along the diagonal of their slot's octant:
/// it takes the best pair first, then exchanges pairs while that helps.
std::array<int, kCwbvhWidth> slots_of(const std::vector<Float4>& offsets) {
  const auto along = [&](int child, std::size_t slot) {
    float sum = 0;
    if (child < 0) return sum;
    for (int axis = 0; axis < 3; ++axis) {
      const float x = offsets[static_cast<std::size_t>(child)][axis];
      sum += (slot >> axis & 1U) != 0 ? -x : x;
    }
    return sum;
  };
  std::array<int, kCwbvhWidth> at;
  at.fill(-1);
  std::uint32_t placed = 0;
  for (std::size_t n = 0; n < offsets.size(); ++n) {
    float best = std::numeric_limits<float>::infinity();
    int chosen = -1;
    std::size_t slot = 0;
    for (int child = 0; child < static_cast<int>(offsets.size()); ++child) {
      if ((placed >> child & 1U) != 0) continue;
      for (std::size_t s = 0; s < kCwbvhWidth; ++s) {
        if (at[s] >= 0 || (chosen >= 0 && !(along(child, s) < best))) continue;
        best = along(child, s), chosen = child, slot = s;
      }
    }
    at[slot] = chosen;
    placed |= 1U << chosen;
  }
  // An exchange lowers a sum of rounded numbers, so rounding could make exchanges go on for ever;
  // four rounds are enough.
  for (int round = 0; round < 4; ++round) {
    for (std::size_t a = 0; a < kCwbvhWidth; ++a) {
      for (std::size_t b = a + 1; b < kCwbvhWidth; ++b)
        if (along(at[a], b) + along(at[b], a) < along(at[a], a) + along(at[b], b)) std::swap(at[a], at[b]);
    }
  }
  return at;
}

class CwbvhEmitter {
 public:
  static constexpr std::size_t kNodeWords = 20;
  CwbvhEmitter(const BinaryTree& tree, Accel& accel) : tree_(tree), collapse_(tree, kCwbvhCosts), accel_(accel) {
    accel_.leaves.reserve(tree.triangles.size());
  }
  [[nodiscard]] float cost() const { return collapse_.cost(); }

  /// Writes node `to` and all nodes below it. Returns the levels of nodes below, which leave at
  /// most one entry each on the stack.
  std::uint32_t emit(std::uint32_t binary, std::size_t to) {
    const std::vector<WideChild> children = collapse_.children(binary);
    Box around;
    for (const WideChild& child : children) around.add(tree_.nodes[child.binary].box());
    // Halving comes before the addition, because the sum of two large numbers may overflow.
    const auto middle = [](const Box& box) { return 0.5F * box.lo + 0.5F * box.hi; };
    std::vector<Float4> offsets;
    for (const WideChild& child : children) offsets.push_back(middle(tree_.nodes[child.binary].box()) - middle(around));
    const std::array<int, kCwbvhWidth> slots = slots_of(offsets);

    const QuantisedFrame frame(around);
    std::uint32_t* node = accel_.nodes.data() + to * kNodeWords;
    const auto own = static_cast<std::uint32_t>(accel_.nodes.size() / kNodeWords);
    const auto own_triangles = static_cast<std::uint32_t>(accel_.leaves.size());
    std::uint32_t inner = 0, are_nodes = 0;
    for (std::size_t slot = 0; slot < kCwbvhWidth; ++slot) {
      if (slots[slot] < 0) continue;
      const WideChild& child = children[static_cast<std::size_t>(slots[slot])];
      const QuantisedBox box = frame.quantise(tree_.nodes[child.binary].box());
      const std::size_t half = slot / 4, shift = 8 * (slot % 4);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node[kCwbvhPlaneWord + 2 * axis + half] |= std::uint32_t{box.lo[axis]} << shift;
        node[kCwbvhPlaneWord + 6 + 2 * axis + half] |= std::uint32_t{box.hi[axis]} << shift;
      }
      std::uint32_t kind = 1U << 5 | 24U | static_cast<std::uint32_t>(slot);
      if (child.leaf) {
        const auto [first, count] = std::pair(tree_.nodes[child.binary].first, tree_.nodes[child.binary].count);
        kind = ((1U << count) - 1) << 5 | (static_cast<std::uint32_t>(accel_.leaves.size()) - own_triangles);
        for (std::uint32_t i = 0; i < count; ++i) accel_.leaves.push_back(tree_.triangles[first + i]);
      } else {
        are_nodes |= 1U << slot;
        ++inner;
      }
      node[kKindWord + half] |= kind << shift;
    }
    std::ranges::copy(frame.words(are_nodes), node);
    node[4] = own;
    node[5] = own_triangles;
    accel_.nodes.resize(std::size_t{own + inner} * kNodeWords);  // `node` is invalid from here on
    std::uint32_t below = 0, next = own;
    for (std::size_t slot = 0; slot < kCwbvhWidth; ++slot) {
      if ((are_nodes >> slot & 1U) == 0) continue;
      below = std::max(below, 1 + emit(children[static_cast<std::size_t>(slots[slot])].binary, next++));
    }
    return below;
  }

 private:
  const BinaryTree& tree_;
  Collapse<kCwbvhWidth> collapse_;
  Accel& accel_;
};

}  // namespace

Accel layout_cwbvh(const BinaryTree& tree) { return quantised_accel<CwbvhEmitter>("cwbvh", tree); }

}  // namespace eikon
