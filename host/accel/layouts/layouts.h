// SPDX-License-Identifier: Apache-2.0
// Lays a binary tree out for a traversal kernel. The kernel's header describes the layout.
#pragma once
#include <string>

#include "accel/accel.h"
#include "accel/binary_tree.h"

namespace eikon {

/// A leaf's child word in bvh2 and bvh4 has 3 bits from here on, which are the number of triangles
/// - 1; below is the first entry in the list.
inline constexpr std::uint32_t kCountShift = 28;

/// A leaf of bvh8 and bvh16: the nine coordinates of eight triangles, and from kBlockTriangles on
/// their indices, which are EK_NO_HIT for an unused one.
inline constexpr std::uint32_t kBlock = 8, kBlockTriangles = 9 * kBlock, kBlockWords = 10 * kBlock;

/// 8- or 16-wide nodes and blocks of up to 8 triangles, chosen to minimise the SAH cost over all
/// ways to collapse the tree [Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal on
/// GPUs through compressed wide BVHs", section 3.1].
[[nodiscard]] Accel layout_bvh8(const BinaryTree& tree, TriangleSoup triangles);
[[nodiscard]] Accel layout_bvh16(const BinaryTree& tree, TriangleSoup triangles);

/// Binary nodes with both children's boxes in the parent, leaves of up to 4 triangles.
[[nodiscard]] Accel layout_bvh2(const BinaryTree& tree);

/// Adds to the nodes of a bvh2 their boxes at each pose of the triangles, for rays with a time.
void fit_bvh2_to_poses(Accel& accel, const TrianglePoses& poses);

/// Makes of each node and each leaf of a bvh8 or bvh16 a row of them, one for each pose, for rays
/// with a time.
void fit_wide_to_poses(Accel& accel, const TrianglePoses& poses);

/// 4-wide nodes with boxes in a byte per plane, leaves of up to 4 triangles.
[[nodiscard]] Accel layout_bvh4(const BinaryTree& tree);

/// 8-wide nodes with boxes in a byte per plane, leaves of up to 3 triangles [as bvh8's source].
[[nodiscard]] Accel layout_cwbvh(const BinaryTree& tree);

/// Lays out by name (of tree_layouts()).
[[nodiscard]] Accel lay_out(const BinaryTree& tree, TriangleSoup triangles, const std::string& layout);

/// Makes no tree, but the list of triangles that can be hit.
[[nodiscard]] Accel layout_none(TriangleSoup triangles);

}  // namespace eikon
