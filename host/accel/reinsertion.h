// SPDX-License-Identifier: Apache-2.0
// A better binary tree: subtrees move to where they cost less.
#pragma once
#include "accel/binary_tree.h"

namespace eikon {

/// Takes subtrees out and puts them back where the sum of the boxes' areas shrinks most, the largest tenth of them in
/// each round, until a round gains little. Subtrees of at most 8 triangles stay whole: the layouts test their triangles at
/// once, so that their inside costs nothing, and moving single triangles was measured to make wide trees worse.
/// Runs with the threads of the current TBB arena; the tree does not depend on their number. returns false, and
/// leaves the tree as it was, where next to nothing is gained, or where depth would exceed the bound of
/// build_binary_tree().
/// source [Bittner, Hapala, Havran 2013, "Fast insertion-based optimization of bounding volume hierarchies"], in batches
/// as [Meister, Bittner 2018, "Parallel reinsertion for bounding volume hierarchy optimization"]
bool reinsert(BinaryTree& tree);

/// True when the tracing time that reinsertion saves exceeds what it takes.
/// rays: how many will be traced, camera, bounce and shadow rays alike
[[nodiscard]] bool reinsertion_pays(std::size_t triangles, double rays);

}  // namespace eikon
