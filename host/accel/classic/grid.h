// SPDX-License-Identifier: Apache-2.0
// Equal cells, for kernels/traverse/classic/grid.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// About 27 cells per triangle, cubes as nearly as they can be, at most 2^27 in all and 4096 along an axis. A triangle is listed in
/// each cell where it may be hit; where that would be more than 16 entries per triangle and 4096 more, cells are larger.
/// The same for any number of threads.
/// throws InputError for more than 2^26 triangles
/// source [Fujimoto, Tanaka, Iwata 1986, "ARTS: accelerated ray-tracing system"]; its density as in [Pharr, Humphreys 2010, PBR,
/// section 4.3]: three cells per triangle along each axis, were they spread evenly
[[nodiscard]] Accel build_grid(TriangleSoup triangles);

}  // namespace eikon
