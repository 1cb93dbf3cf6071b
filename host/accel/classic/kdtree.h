// SPDX-License-Identifier: Apache-2.0
// Space parted by planes across one axis each, for kernels/traverse/classic/kdtree.h.
#pragma once
#include "accel/accel.h"

namespace eikon {

enum class KdSplit {
  sah,     // the plane that the surface area heuristic finds best, from bins or, of few triangles, all planes
  rotate,  // the middle of the cell, axes in turn, until few triangles are left
};

/// The same tree for any number of threads. A triangle is listed in each leaf where it may be hit; all lists together have at
/// most 16 entries per triangle and 4096 more. Depth is at most 8 + 1.3 log2(n), of `rotate` 48.
/// throws InputError for more than 2^26 triangles
/// source [Wald, Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)"] for the heuristic;
/// [Pharr, Jakob, Humphreys 2023, PBR, section 7.3.2 of its second edition] for when to stop
[[nodiscard]] Accel build_kdtree(TriangleSoup triangles, KdSplit split);

}  // namespace eikon
