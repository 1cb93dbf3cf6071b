// SPDX-License-Identifier: Apache-2.0
// The classical bounding volume hierarchy, split at the median.
#pragma once
#include "accel/binary_tree.h"

namespace eikon {

/// Each node is split along the longest axis of its triangles' centres, at their median, which
/// quickselect finds [Hoare 1961, algorithm 65]. Like other trees it goes down to single triangles,
/// which layouts join to leaves: bvh2 and bvh4 of at most 4, the others of at most 8. Depth is at
/// most log2(n) + 1.
/// throws InputError for more than 2^28 triangles
/// source [Kay, Kajiya 1986, "Ray tracing complex scenes"]
[[nodiscard]] BinaryTree build_median_tree(TriangleSoup triangles);

}  // namespace eikon
