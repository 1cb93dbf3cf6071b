// SPDX-License-Identifier: Apache-2.0
// Improves a binary tree by moving subtrees to places where they cost less.
#pragma once
#include "accel/binary_tree.h"

namespace eikon {

/// Takes subtrees out and puts them back where the sum of the boxes' areas shrinks most. Each round
/// moves the largest tenth, until a round gains little. Subtrees of at most 8 triangles stay whole:
/// the layouts test their triangles at once, so that their inside costs nothing, and moving single
/// triangles was measured to make wide trees worse. Runs with the threads of the current TBB arena;
/// the tree does not depend on their number.
/// returns  false, and leaves the tree as it was, if next to nothing is gained, or if the depth
///          would exceed the bound of build_binary_tree()
/// source [Bittner, Hapala, Havran 2013, "Fast insertion-based optimization of bounding volume
/// hierarchies"], in batches as [Meister, Bittner 2018, "Parallel reinsertion for bounding volume
/// hierarchy optimization"]
bool reinsert(BinaryTree& tree);

/// True when reinsertion saves more tracing time than it takes.
/// rays: number of rays to be traced, of all kinds
[[nodiscard]] bool reinsertion_pays(std::size_t triangles, double rays);

}  // namespace eikon
