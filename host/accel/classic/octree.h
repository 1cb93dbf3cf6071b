// SPDX-License-Identifier: Apache-2.0
// Octrees for kernels/traverse/classic/octree.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. There are at most
/// 16 levels. Leaves have up to 6 triangles, and more where dividing them gains nothing.
/// throws InputError for more than 2^26 triangles
/// source [Glassner 1984, "Space subdivision for fast ray tracing"]
[[nodiscard]] Accel build_octree(TriangleSoup triangles);

}  // namespace eikon
