// SPDX-License-Identifier: Apache-2.0
// Cubes parted in eight, for kernels/traverse/classic/octree.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// The same tree for any number of threads. A triangle is listed in each leaf where it may be hit; all lists together have at
/// most 16 entries per triangle and 4096 more. At most 16 levels; leaves of up to 6 triangles, more where dividing gains nothing.
/// throws InputError for more than 2^26 triangles
/// source [Glassner 1984, "Space subdivision for fast ray tracing"]
[[nodiscard]] Accel build_octree(TriangleSoup triangles);

}  // namespace eikon
