// SPDX-License-Identifier: Apache-2.0
// BSP trees, with planes of any direction, for kernels/traverse/classic/bsp.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// The upper part, where nodes have many triangles, is a kd-tree. Below it the surface area
/// heuristic chooses between the best plane of a kd-tree and planes of some triangles and through
/// their edges, whose steps cost more. A bounded number of those is tried on a bounded number of
/// triangles per node, so that building takes O(n log n) with some tens of microseconds per node.
/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. Depth is at most 8
/// + 1.3 log2(n).
/// throws InputError for more than 2^26 triangles
/// source [Ize, Wald, Parker 2008, "Ray tracing with the BSP tree", section 3]
[[nodiscard]] Accel build_bsp(TriangleSoup triangles);

}  // namespace eikon
