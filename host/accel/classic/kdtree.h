// SPDX-License-Identifier: Apache-2.0
// kd-trees for kernels/traverse/classic/kdtree.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

enum class KdSplit {
  sah,     // the best plane by the surface area heuristic, of bins, or of all planes if triangles are few
  rotate,  // the middle of the cell, across each axis in turn, until few triangles are left
};

/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. Depth is at most 8
/// + 1.3 log2(n); with `rotate` it is at most 48.
/// throws InputError for more than 2^26 triangles
/// source [Wald, Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N
/// log N)"] for the heuristic; [Pharr, Jakob, Humphreys 2023, PBR, section 7.3.2 of its second
/// edition] for when to stop
[[nodiscard]] Accel build_kdtree(TriangleSoup triangles, KdSplit split);

}  // namespace eikon
