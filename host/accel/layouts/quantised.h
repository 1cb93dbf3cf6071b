// SPDX-License-Identifier: Apache-2.0
// Boxes of a node's children with a byte per plane: plane = origin + byte * 2^(exponent - 127), in
// the float arithmetic of kernels/traverse/quantised.h.
#pragma once
#include <array>
#include <cstdint>

#include "accel/accel.h"
#include "accel/binary_tree.h"
#include "accel/box.h"

namespace eikon {

struct QuantisedBox {
  std::array<std::uint8_t, 3> lo, hi;
};

/// The origin and the steps of the bytes of a node's children.
class QuantisedFrame {
 public:
  /// around: a box that contains all children; finite, not empty
  explicit QuantisedFrame(const Box& around);

  /// The narrowest box in this frame that contains `box`, which lies within `around`. It does so in
  /// the kernels' rounded arithmetic too. A plane beyond the largest float is infinite, and is
  /// correct as well.
  [[nodiscard]] QuantisedBox quantise(const Box& box) const;

  /// Words 0 to 3 of a node. top: the highest byte of the last
  [[nodiscard]] std::array<std::uint32_t, 4> words(std::uint32_t top) const;

 private:
  [[nodiscard]] float plane(std::size_t axis, int byte) const;

  std::array<float, 3> origin_{};
  std::array<std::uint32_t, 3> exponent_{};  // biased by 127; 1 to 254, so that no step is denormal
};

/// Lays out a tree by an Emitter(tree, accel). Without triangles it is one node without children,
/// whose words are 0.
template <class Emitter>
Accel quantised_accel(const char* layout, const BinaryTree& tree) {
  Accel accel{.name = "bvh", .layout = layout};
  accel.nodes.resize(Emitter::kNodeWords, 0);
  if (tree.nodes.empty()) {
    accel.leaves.resize(1, 0);
  } else {
    Emitter emitter(tree, accel);
    accel.stack_size = 1 + emitter.emit(0, 0);
    const float root = tree.nodes[0].box().half_area();
    accel.sah_cost = root > 0 ? static_cast<double>(emitter.cost() / root) : 0.0;
  }
  accel.node_count = accel.nodes.size() / Emitter::kNodeWords;
  return accel;
}

}  // namespace eikon
