// SPDX-License-Identifier: Apache-2.0
// Fits a tree to triangles that have moved, without building it anew. It gets worse the further
// they have moved.
#pragma once
#include <optional>

#include "accel/binary_tree.h"

namespace eikon {

/// The tree with the boxes of the moved triangles. Hits are those of a tree built anew, to the bit.
/// moved    the triangles that the tree was built over, in the same order
/// returns  nothing if triangles outside the tree have gained area, or triangles in it have lost
///          theirs: build anew then Accel::sah_cost of the new layout tells whether a new tree
///          would pay.
[[nodiscard]] std::optional<BinaryTree> refitted(BinaryTree tree, TriangleSoup moved);

}  // namespace eikon
