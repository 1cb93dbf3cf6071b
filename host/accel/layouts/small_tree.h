// SPDX-License-Identifier: Apache-2.0
// Builds subtrees of a few triangles from every split of every axis in sorted order, because bins
// are too coarse for them.
#pragma once
#include "accel/binary_tree.h"
#include "accel/reference.h"

namespace eikon {

class SmallTree {
 public:
  static constexpr std::size_t kLimit = 32;

  /// Sorts references[0, count), count <= kLimit, along each axis. triangles: the tree's
  SmallTree(const Reference* references, std::size_t count, std::uint32_t* triangles);

  /// Writes the subtree of all references to nodes[0, 2 * count - 1). box: of all; first: index of
  /// its first triangle
  void build(BinaryNode* nodes, std::size_t first, const Box& box) {
    first_ = first;
    build(nodes, 0, count_, box);
  }

 private:
  using Order = std::array<std::uint8_t, kLimit>;
  void build(BinaryNode* nodes, std::size_t begin, std::size_t end, const Box& box);
  void divide(std::size_t begin, std::size_t end, std::size_t axis, std::size_t middle);

  const Reference* references_;
  std::size_t count_, first_ = 0;
  std::uint32_t* triangles_;
  std::array<Order, 3> order_{};
};

}  // namespace eikon
