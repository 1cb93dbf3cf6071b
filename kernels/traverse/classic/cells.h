// SPDX-License-Identifier: Apache-2.0
// What structures that divide space share: cells instead of boxes around triangles. Their traversals find the hits of brute force, to the
// bit, because of what follows. u is 2^-24, E the ray's reach, pad its pad (ray.h); I(box) the interval of a box as computed there,
// without the 0 at which rays begin; t the parameter that the test of triangle T gives (traverse/triangle.h).
//
// 1. t lies in I(box of T), so in I(C and box of T) for some cell C of any division of space into boxes: where a plane p parts a box, the
//    part met first ends at fl((p - f) r), the other begins at fl((p - n) r), and since n is not before f, no t of the whole lies in
//    neither. This holds as computed, for every ray. So whoever lists T in all cells that its box meets, and visits the cells whose I is
//    not empty and begins at or before the best t so far, tests T before it stops. A plane that only touches the box may leave T to
//    either side.
// 2. A triangle's box is much larger than a slanted triangle. T is left out of cells where C and its box do not come near T's plane.
//    How near P = o + t d is to the plane. Of T, s is the longest side of its box, M the product of two edges; C' is C and what is
//    as near to it as P may be, 40 u E + 4 u |o| on each axis.
//    - The corners as the test sees them, sheared, are off by at most 7 u E, unsheared by 8 u E on two axes and u E on the third: 11.4 u E.
//      Call their triangle T'. Where 664 u E times the longest side of its C' is at most |M|, |M'| is at least 7/8 |M|; other triangles
//      are in all cells of their box. The ray passes within T', exactly, since signs are. What is a mean of the corners of T' by
//      weights whose sizes add up to w is within 11.4 w u E of T's plane; a point of C' is one of T by at most W, so of T' by
//      8/7 (W + .2): 14 (W + 1) u E.
//    - t is a mean of the corners' depths by weights that are off by 12 u X Y / |det| in all, for an extent X by Y of the sheared triangle,
//      each at most 2 s: |det| times an error of t times the depth of T, by |M'|, is the distance from the plane of T', at most
//      55 u s^3 / |M|; and its own rounding is 10 u E along the ray, 18 u E in all.
//    - A t found anew is of a triangle that begins no deeper than the origin, so within 2 s of it. The mean by the weights is on T's plane
//      but for 20 u E. The normal is off by 7 u s^2, which counts for 4 s; det by 112 u s^2 for the corners and 48 u s^2, which count
//      for a depth of s: 188 u s^3 / |M|.
//    - Clamping moves P towards where the ray does pass T.
//    All that is the slack of host/accel/classic/cells.cpp for E up to a limit.
//    (Within its plane, P may be anywhere in the box when the ray is seen edge-on: T's edges cannot shrink a list.)
// 3. A far ray, of a reach beyond that limit, visits all cells that its whole line passes, however near a hit. It does pass T within
//    7 u E, hence a point V of T; V lies in a cell that lists T, and the pad is four times as large.
// No cell is left out by arithmetic on directions or cell numbers alone; duplicates do no harm, a triangle always gives the same answer.
#ifndef EK_TRAVERSE_CELLS_H
#define EK_TRAVERSE_CELLS_H
#include "traverse/hit.h"

#define USE_CELLS (EK_LAYOUT_grid | EK_LAYOUT_octree | EK_LAYOUT_kdtree | EK_LAYOUT_bsp)
#if USE_CELLS

// The first words of accel_nodes: the limit of reach; lo and hi of the box around all triangles; from 7 what each structure says;
// at 13 and 14 where in `leaves` the list of what has no end is, and so is in no cell, and how long it is.
#define CELLS_HEADER 16u

typedef struct {
  float r[3], n[3], f[3];  // as in RayOne, by axis
  int far;
  float begin, end;  // of what it may pass of the scene's box; nothing if end is less
} CellRay;

EK_FN CellRay cell_ray(Geometry geometry, const RayOne* ray, const Hit* hit) {
  global const float* header = (global const float*)geometry.nodes;
  CellRay c;
  c.r[0] = ray->rx; c.r[1] = ray->ry; c.r[2] = ray->rz;
  c.n[0] = ray->nx; c.n[1] = ray->ny; c.n[2] = ray->nz;
  c.f[0] = ray->fx; c.f[1] = ray->fy; c.f[2] = ray->fz;
  c.far = !(ray->reach <= header[0]);
  c.begin = c.far ? -INFINITY : 0.0f;
  c.end = c.far ? INFINITY : hit->t;
  for (uint k = 0; k < 3; ++k) {
    const float lo = header[1 + k], hi = header[4 + k];
    c.begin = shape_max_one(c.begin, ((c.r[k] < 0.0f ? hi : lo) - c.n[k]) * c.r[k]);
    c.end = shape_min_one(c.end, ((c.r[k] < 0.0f ? lo : hi) - c.f[k]) * c.r[k]);
  }
  return c;
}

// Where a ray's way on this side of a plane ends, and where that beyond begins; falls: it comes from above, or from in front.
typedef struct {
  float first_end, second_begin;
  int falls;
} CellParts;

// Whether what begins there cannot hold the closest hit.
EK_FN int is_behind(const CellRay* c, const Hit* hit, float begin) { return (!c->far) & (begin > hit->t); }

// Tests the triangles of a list. returns 1 if one settles an any-hit query.
EK_FN int try_list(Geometry geometry, const RayOne* ray, uint first, uint count, const int any_hit, Hit* hit) {
  for (uint i = 0; i < count; ++i) {
    if (try_triangle(geometry, ray, geometry.leaves[first + i], any_hit, hit)) return 1;
  }
  return 0;
}

#if EK_LAYOUT_grid
#include "traverse/classic/grid.h"
#elif EK_LAYOUT_octree
#include "traverse/classic/octree.h"
#else
#include "traverse/classic/kdtree.h"
#endif

EK_FN int traverse_space(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
#if EK_HAS_plane
  if (try_list(geometry, ray, geometry.nodes[13], geometry.nodes[14], any_hit, hit)) return 1;
#endif
  return traverse_cells(geometry, ray, any_hit, hit);
}
#endif

#endif
