// SPDX-License-Identifier: Apache-2.0
// Layout `octree`: cells that are divided in eight at a point. After the header come nodes of 12
// words:
//   words 0-2   the point
//   words 3-10  children; bits 0, 1, 2 of a child's number say that it is beyond the point on x, y,
//               z. A word is 0 where nothing is, the index of an inner node, or bit 31 | the place
//               of a leaf in `leaves`: the number of its triangles, then those
// Children are visited in the order in which the ray could meet them: number 0 comes first if the
// ray goes up on all axes, and none comes before those whose bits are among its own [Revelles,
// Urena, Lastra 2000, "An efficient parametric algorithm for octree traversal"].
#ifndef EK_TRAVERSE_OCTREE_H
#define EK_TRAVERSE_OCTREE_H
#include "traverse/classic/cells.h"

EK_FN int traverse_cells(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  const CellRay c = cell_ray(geometry, ray, hit);
  const uint mirror = (c.r[0] < 0.0f ? 1u : 0u) | (c.r[1] < 0.0f ? 2u : 0u) | (c.r[2] < 0.0f ? 4u : 0u);
  CellStack stack = {.size = 0};
  uint current = 0;
  float begin = c.begin, end = c.end;
  if (!(begin <= end)) return 0;
  for (;;) {
    EK_COUNT_STEP(hit);
    if (!(current & 0x80000000u)) {
      global const uint* p = geometry.nodes + CELLS_HEADER + (size_t)current * 12;
      float first_end[3], second_begin[3];
      for (uint k = 0; k < 3; ++k) {
        const float plane = as_float(p[k]);
        first_end[k] = shape_min_one(end, (plane - c.f[k]) * c.r[k]);
        second_begin[k] = shape_max_one(begin, (plane - c.n[k]) * c.r[k]);
      }
      for (uint k = 0; k < 8; ++k) {
        const uint order = 7u - k;  // the first child that is met ends on top
        const uint child = p[3u + (order ^ mirror)];
        const float bx = (order & 1u) ? second_begin[0] : begin, ex = (order & 1u) ? end : first_end[0];
        const float by = (order & 2u) ? second_begin[1] : begin, ey = (order & 2u) ? end : first_end[1];
        const float bz = (order & 4u) ? second_begin[2] : begin, ez = (order & 4u) ? end : first_end[2];
        const float b = shape_max_one(shape_max_one(bx, by), bz), e = shape_min_one(shape_min_one(ex, ey), ez);
        if ((child != 0u) & (b <= e)) cell_push(&stack, child, b, e, 1);
      }
    } else {
      const uint leaf = current & 0x7fffffffu;
      if (try_list(geometry, ray, leaf + 1u, geometry.leaves[leaf], any_hit, hit)) return 1;
    }
    if (!cell_pop(&stack, &c, hit, &current, &begin, &end)) return 0;
  }
}

#endif
