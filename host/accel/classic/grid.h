// SPDX-License-Identifier: Apache-2.0
// Uniform grids for kernels/traverse/classic/grid.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

/// There are about 27 cells per triangle, nearly cubes, at most 2^27 in all and 4096 along an axis.
/// Each cell lists the triangles that may be hit in it; if that would make more than 16 entries per
/// triangle and 4096 more, cells are larger. The grid does not depend on the number of threads.
/// throws InputError for more than 2^26 triangles
/// source [Fujimoto, Tanaka, Iwata 1986, "ARTS: accelerated ray-tracing system"]; the density is
/// that of [Pharr, Humphreys 2010, PBR, section 4.3]: three cells per triangle along each axis, if
/// triangles were spread evenly
[[nodiscard]] Accel build_grid(TriangleSoup triangles);

}  // namespace eikon
