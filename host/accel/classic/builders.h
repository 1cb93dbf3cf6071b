// SPDX-License-Identifier: Apache-2.0
// The builders of classical structures. <name>.cpp has each, for kernels/traverse/classic/<name>.h.
#pragma once
#include "accel/accel.h"
#include "accel/binary_tree.h"

namespace eikon {

#define EK_CELLS(name, about) [[nodiscard]] Accel build_##name(TriangleSoup triangles);
#include "shared/layouts.def"
[[nodiscard]] Accel build_kdtree_rotate(TriangleSoup triangles);
[[nodiscard]] BinaryTree build_median_tree(TriangleSoup triangles);

}  // namespace eikon
