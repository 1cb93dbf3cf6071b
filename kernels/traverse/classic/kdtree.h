// SPDX-License-Identifier: Apache-2.0
// Layouts `kdtree`, space divided by planes across one axis each, and `bsp`, divided by those and
// by oblique ones. After the header come nodes, whose indices count in units of two words:
//   across   plane; axis | index of the child above it << 3
//   leaf     first entry of its triangles in `leaves`; 3 | their number << 3
//   oblique  d; 4 | index of the child in front << 3; n, 0 (traverse/classic/bsp.h)
// The child below or behind comes next in memory. Traversal goes front to back with a stack
// [Hapala, Havran 2011, "Review: kd-tree traversal algorithms for ray tracing", algorithm TA-B
// rec]. As computed, the first child ends no earlier than the second begins. So a ray passes at
// least one of them, and a step needs no branch but those on the kind of node.
#ifndef EK_TRAVERSE_KDTREE_H
#define EK_TRAVERSE_KDTREE_H
#include "traverse/classic/cells.h"
#if EK_LAYOUT_bsp
#include "traverse/classic/bsp.h"
#endif

#define KD_LEAF 3u
#define KD_OBLIQUE 4u

EK_FN int traverse_cells(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  global const uint* nodes = geometry.nodes + CELLS_HEADER;
  const CellRay c = cell_ray(geometry, ray, hit);
#if EK_LAYOUT_bsp
  const BspRay oblique = bsp_ray(geometry, ray);
#endif
  CellStack stack = {.size = 0};
  uint current = 0;
  float begin = c.begin, end = c.end;
  if (!(begin <= end)) return 0;
  for (;;) {
    global const uint* p = nodes + 2 * (size_t)current;
    const uint word = p[1], kind = word & 7u;
    EK_COUNT_STEP(hit);
    if (kind != KD_LEAF) {
      uint below = current + 1u;
      CellParts parts;
#if EK_LAYOUT_bsp
      if (kind == KD_OBLIQUE) {
        parts = bsp_parts(&oblique, ray, (global const float*)p);
        below = current + 3u;
      } else
#endif
      {
        const float plane = as_float(p[0]), r = c.r[kind];
        parts.first_end = (plane - c.f[kind]) * r;
        parts.second_begin = (plane - c.n[kind]) * r;
        parts.falls = r < 0.0f;
      }
      const uint above = word >> 3;
      const uint first = parts.falls ? above : below, second = parts.falls ? below : above;
      const float second_begin = shape_max_one(begin, parts.second_begin);
      const int in_first = begin <= parts.first_end;
      cell_push(&stack, second, second_begin, end, in_first & (second_begin <= end));
      current = in_first ? first : second;
      end = in_first ? shape_min_one(end, parts.first_end) : end;
      continue;
    }
    if (try_list(geometry, ray, p[0], word >> 3, any_hit, hit)) return 1;
    if (!cell_pop(&stack, &c, hit, &current, &begin, &end)) return 0;
  }
}

#endif
