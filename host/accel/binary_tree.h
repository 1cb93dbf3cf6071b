// SPDX-License-Identifier: Apache-2.0
// The tree from which every layout is made: binary, one triangle per leaf, split by the surface
// area heuristic.
#pragma once
#include <cstdint>

#include "accel/accel.h"
#include "accel/box.h"
#include "core/device_vector.h"

namespace eikon {

/// Nodes lie depth first: the left child of node i is i + 1, the right one i + 2 * (count of the
/// left child), since a subtree of n triangles has 2n - 1 nodes. A node's triangles are the entries
/// [first, first + count) of BinaryTree::triangles; as many leaves as `first` lie before it, so
/// that it is inner node i - first.
struct BinaryNode {
  float lo[3];
  std::uint32_t count;
  float hi[3];
  std::uint32_t first;     // of its triangles
  BinaryNode() = default;  // unset: trees have millions
  BinaryNode(const Box& box, std::size_t triangle_count, std::size_t first_triangle)
      : lo{box.lo[0], box.lo[1], box.lo[2]},
        count(static_cast<std::uint32_t>(triangle_count)),
        hi{box.hi[0], box.hi[1], box.hi[2]},
        first(static_cast<std::uint32_t>(first_triangle)) {}
  [[nodiscard]] Box box() const { return {Float4{lo[0], lo[1], lo[2], 0}, Float4{hi[0], hi[1], hi[2], 0}}; }
};

struct BinaryTree {
  BigVector<BinaryNode> nodes;         // nodes[0] is the root; empty when there is no triangle
  BigVector<std::uint32_t> triangles;  // indices into the soup, in the order of the leaves
  // In a scene of two levels, indices from first_instance on are instances, which share no leaf
  // with triangles; instances_before counts the instances before each entry of `triangles`, and in
  // all. It is empty otherwise.
  std::uint32_t first_instance = 0xffffffffU;
  BigVector<std::uint32_t> instances_before{};
  bool is_part = false;  // the tree is one of a scene in two levels
  [[nodiscard]] bool has_instance(const BinaryNode& node) const {
    return !instances_before.empty() && instances_before[node.first] != instances_before[node.first + node.count];
  }
  /// The child word, in every layout, of a leaf that is an instance (traverse_instance.h).
  [[nodiscard]] std::uint32_t instance_word(const BinaryNode& node) const {
    return 0xc0000000U | (triangles[node.first] - first_instance);
  }
};

inline std::uint32_t left_child(std::uint32_t node) { return node + 1; }
inline std::uint32_t right_child(const BinaryTree& tree, std::uint32_t node) {
  return node + 2 * tree.nodes[node + 1].count;
}

/// True when the triangle has no area, or a corner that is not finite: no ray may hit it, in any
/// layout.
[[nodiscard]] bool is_degenerate(const float corners[9]);

/// Box of a triangle's corners. -0 becomes +0, so that the bits of unions do not depend on their
/// order.
[[nodiscard]] Box triangle_box(const float corners[9]);

/// The same for entry `i` of a soup; boxes can be hit.
[[nodiscard]] inline bool is_degenerate(const TriangleSoup& soup, std::size_t i) {
  return !soup.is_box(i) && is_degenerate(soup.corners(i));
}
[[nodiscard]] Box triangle_box(const TriangleSoup& soup, std::size_t i);

/// Builds with the threads of the current TBB arena; the tree does not depend on their number.
/// Depth is at most 64 + log2(n), whatever the geometry. Degenerate triangles are left out.
/// throws InputError for more than 2^28 triangles
/// source [Wald 2007, "On fast construction of SAH-based bounding volume hierarchies"], with 32
/// bins, and a full sweep for small nodes
[[nodiscard]] BinaryTree build_binary_tree(TriangleSoup triangles);

}  // namespace eikon
