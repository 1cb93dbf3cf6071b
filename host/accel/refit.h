// SPDX-License-Identifier: Apache-2.0
// A tree follows triangles that move, without being built anew; it grows worse the further they go.
#pragma once
#include <optional>

#include "accel/binary_tree.h"

namespace eikon {

/// The tree with boxes of the triangles as they are now: hits are those of a tree built anew, to the bit. `moved` are the
/// triangles it was built over, in their order. Empty where triangles that were left out of the tree have gained area, or
/// others have lost theirs: build anew. Whether a new tree would pay shows in Accel::sah_cost of the layout made of it.
[[nodiscard]] std::optional<BinaryTree> refitted(BinaryTree tree, TriangleSoup moved);

}  // namespace eikon
