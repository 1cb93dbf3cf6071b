// SPDX-License-Identifier: Apache-2.0
// Boxes of a node's children in a byte per plane: plane = origin + byte * 2^(exponent - 127), in the floats of kernels/traverse/quantised.h.
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

/// Where the bytes of a node's children count from, and in what steps.
class QuantisedFrame {
 public:
  /// around: what holds all of the children; finite, not empty.
  explicit QuantisedFrame(const Box& around);

  /// The narrowest box in this frame that holds `box`, a part of what the frame is around. It does in the kernels' rounded
  /// arithmetic, not only in numbers; a plane beyond the largest float is infinite, and holds as well.
  [[nodiscard]] QuantisedBox quantise(const Box& box) const;

  /// Words 0-3 of a node; `top`: the highest byte of the last.
  [[nodiscard]] std::array<std::uint32_t, 4> words(std::uint32_t top) const;

 private:
  [[nodiscard]] float plane(std::size_t axis, int byte) const;

  std::array<float, 3> origin_{};
  std::array<std::uint32_t, 3> exponent_{};  // biased by 127; 1 to 254, so that no step is denormal
};

/// What an Emitter(tree, accel) makes of a tree; without triangles one node without children, whose words are 0.
template <class Emitter>
Accel quantised_accel(const char* layout, const BinaryTree& tree) {
  Accel accel;
  accel.name = "bvh";
  accel.layout = layout;
  if (tree.nodes.empty()) {
    accel.nodes.resize(Emitter::kNodeWords, 0);
    accel.leaves.resize(1, 0);
  } else {
    const Emitter emitter(tree, accel);
  }
  accel.node_count = accel.nodes.size() / Emitter::kNodeWords;
  return accel;
}

}  // namespace eikon
