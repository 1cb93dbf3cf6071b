// SPDX-License-Identifier: Apache-2.0
// Space parted by planes of any direction, for kernels/traverse/classic/bsp.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// A kd-tree where many triangles are left. Below, planes are chosen by the surface area heuristic among the kd-tree's best across an axis
/// and those of some triangles and through their edges, whose steps count more. A bounded number of those is tried on a bounded
/// number of triangles per node, so that the time to build is O(n log n) with some tens of microseconds per node. The same tree for any number of threads. A triangle is listed in each
/// leaf where it may be hit; all lists together have at most 16 entries per triangle and 4096 more. Depth is at most
/// 8 + 1.3 log2(n).
/// throws InputError for more than 2^26 triangles
/// source [Ize, Wald, Parker 2008, "Ray tracing with the BSP tree", section 3]
[[nodiscard]] Accel build_bsp(TriangleSoup triangles);

}  // namespace eikon
