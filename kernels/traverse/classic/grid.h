// SPDX-License-Identifier: Apache-2.0
// Layout `grid`: equal cells. The header has from word 7 the numbers of cells on x, y, z, and the
// cells per metre on them. After it come the planes of x, of y, of z, one more than cells; then
// where the triangles of each cell begin in `leaves`, x fastest, and where the last ones end.
// Traversal is 3D-DDA [Amanatides, Woo 1987] by slices: one slice of cells after another along the
// longest axis of the direction, and in it the few cells that the ray can pass there, whose range
// moves along with it [Wald, Ize, Kensler, Knoll, Parker 2006, "Ray tracing animated scenes using
// coherent grid traversal", for one ray]. Unlike steps to the nearest plane, this meets all cells
// at a face, edge or corner that the ray runs along, as cells.h demands. Planes are read from a
// table, so that no error adds up.
#ifndef EK_TRAVERSE_GRID_H
#define EK_TRAVERSE_GRID_H
#include "traverse/classic/cells.h"

// One axis. The numbers q count its cells in the order in which the ray meets them.
typedef struct {
  global const float* planes;
  int count, backward;
  uint stride;
  float r, n, f, lo, per_metre;
} GridAxis;

EK_FN GridAxis grid_axis(Geometry geometry, const CellRay* c, uint axis) {
  global const uint* header = geometry.nodes;
  const uint nx = header[7], ny = header[8];
  GridAxis a;
  a.planes = (global const float*)(geometry.nodes + CELLS_HEADER) + (axis > 0u ? nx + 1u : 0u) + (axis > 1u ? ny + 1u : 0u);
  a.count = (int)header[7u + axis];
  a.stride = axis == 0u ? 1u : axis == 1u ? nx : nx * ny;
  a.r = c->r[axis];
  a.n = c->n[axis];
  a.f = c->f[axis];
  a.backward = a.r < 0.0f;
  a.lo = ((global const float*)header)[1u + axis];
  a.per_metre = ((global const float*)header)[10u + axis];
  return a;
}
EK_FN int grid_cell(const GridAxis* a, int q) { return a->backward ? a->count - 1 - q : q; }
EK_FN float grid_begin(const GridAxis* a, int q) { return (a->planes[grid_cell(a, q) + (a->backward ? 1 : 0)] - a->n) * a->r; }
EK_FN float grid_end(const GridAxis* a, int q) { return (a->planes[grid_cell(a, q) + (a->backward ? 0 : 1)] - a->f) * a->r; }

// The first cell from q on that does not end before t, or the last one.
EK_FN int grid_skip(const GridAxis* a, int q, float t) {
  while ((q + 1 < a->count) && grid_end(a, q) < t) ++q;
  return q;
}
// The same for t alone: a guess at the cell, which steps then correct.
EK_FN int grid_find(const GridAxis* a, float t) {
  const float x = ((a->f + div_f(t, a->r)) - a->lo) * a->per_metre, most = (float)(a->count - 1);
  const int cell = x > 0.0f ? (int)(x < most ? x : most) : 0;
  int q = a->backward ? a->count - 1 - cell : cell;
  while ((q > 0) && grid_end(a, q - 1) >= t) --q;
  return grid_skip(a, q, t);
}

EK_FN int traverse_cells(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  const CellRay c = cell_ray(geometry, ray, hit);
  if (!(c.begin <= c.end)) return 0;
  const uint z_axis = ray->axis_z / 8u, x_axis = ray->axis_x / 8u, y_axis = 3u - z_axis - x_axis;
  const GridAxis x = grid_axis(geometry, &c, x_axis), y = grid_axis(geometry, &c, y_axis), z = grid_axis(geometry, &c, z_axis);
  global const uint* header = geometry.nodes;
  global const uint* first = header + CELLS_HEADER + header[7] + header[8] + header[9] + 3u;

  int qx = grid_find(&x, c.begin), qy = grid_find(&y, c.begin);
  for (int qz = grid_find(&z, c.begin); qz < z.count; ++qz) {
    const float begin = shape_max_one(c.begin, grid_begin(&z, qz)), end = shape_min_one(c.end, grid_end(&z, qz));
    if ((begin > c.end) | is_behind(&c, hit, begin)) return 0;
    qx = grid_skip(&x, qx, begin);
    qy = grid_skip(&y, qy, begin);
    const uint slice = (uint)grid_cell(&z, qz) * z.stride;
    for (int i = qx; i < x.count; ++i) {
      const float begin_x = shape_max_one(begin, grid_begin(&x, i)), end_x = shape_min_one(end, grid_end(&x, i));
      if (begin_x > end) break;
      const uint row = slice + (uint)grid_cell(&x, i) * x.stride;
      for (int j = qy; j < y.count; ++j) {
        const float begin_y = shape_max_one(begin_x, grid_begin(&y, j)), end_y = shape_min_one(end_x, grid_end(&y, j));
        if (begin_y > end_x) break;
        EK_COUNT_STEP(hit);
        if ((begin_y > end_y) | is_behind(&c, hit, begin_y)) continue;
        const uint cell = row + (uint)grid_cell(&y, j) * y.stride, from = first[cell];
        if (try_list(geometry, ray, from, first[cell + 1u] - from, any_hit, hit)) return 1;
      }
    }
  }
  return 0;
}

#endif
