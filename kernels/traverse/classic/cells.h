// SPDX-License-Identifier: Apache-2.0
// The common part of structures that divide space into cells, instead of boxes around triangles,
// and the proof that their traversals find the hits of brute force, to the bit. In it u is 2^-24; E
// is the ray's extent and pad its pad (ray.h); I(box) is the interval of a box as computed there,
// without the 0 at which rays begin; t is the parameter that the test of triangle T gives
// (triangle.h).
//
// 1. t lies in I(box of T), and so in I(C and box of T) for some cell C of any division of space
//    into boxes. For where a plane p divides a box, the part that is met first ends at fl((p -
//    o_far) r), and the other begins at fl((p - o_near) r). Since o_near is not before o_far, every
//    t of the whole lies in one of the two. This holds as computed, for every ray. So a structure
//    that lists T in all cells that its box meets, and visits the cells whose I is not empty and
//    begins at or before the best t so far, tests T before it stops. A plane that only touches the
//    box may leave T to either side.
// 2. The box of a slanted triangle is much larger than the triangle. So T is left out of cells
//    where C and its box do not come near T's plane. The following bounds the distance of P = o + t
//    d from the plane. For T, s is the longest side of its box, and M the product of two edges. C'
//    is C grown by as much as P may be off, 40 u E + 4 u |o| on each axis.
//    - The corners as the test sees them, sheared, are off by at most 7 u E; unsheared, by 8 u E on
//      two axes and u E on the third: 11.4 u E. Call their triangle T'. Where 664 u E times the
//      longest side of its C' is at most |M|, |M'| is at least 7/8 |M|; all other triangles are
//      listed in all cells of their box. The ray passes within T', exactly, because the signs are
//      exact. A mean of the corners of T' by weights whose sizes add up to w is within 11.4 w u E
//      of T's plane; a point of C' is one of T by at most W, so of T' by 8/7 (W + .2): 14 (W + 1) u
//      E.
//    - t is a mean of the corners' depths by weights that are off by 12 u X Y / |det| in all, for
//      an extent X by Y of the sheared triangle, each at most 2 s. |det| times an error of t times
//      the depth of T, divided by |M'|, is the distance from the plane of T', at most 55 u s^3 /
//      |M|; and its own rounding is 10 u E along the ray, 18 u E in all.
//    - A t is computed anew only for a triangle that begins no deeper than the origin, so within 2
//      s of it. The mean by the weights is on T's plane but for 20 u E. The normal is off by 7 u
//      s^2, which counts for 4 s; det by 112 u s^2 for the corners and 48 u s^2, which count for a
//      depth of s: 188 u s^3 / |M|.
//    - Clamping moves P towards where the ray does pass T.
//    The sum of all that is the slack of host/accel/classic/cells.cpp, for E up to a limit. (Within
//    its plane, P may be anywhere in the box when the ray sees T edge-on. So T's edges cannot
//    shrink a list.)
// 3. A far ray, whose extent is beyond that limit, visits all cells that its whole line passes,
//    however near a hit. It passes T within 7 u E, hence near a point V of T. V lies in a cell that
//    lists T, and the pad is four times as large.
// No cell is left out by arithmetic on directions or cell numbers alone. Duplicates do no harm,
// because a triangle always gives the same answer.
#ifndef EK_TRAVERSE_CELLS_H
#define EK_TRAVERSE_CELLS_H
#include "traverse/hit.h"

// The first words of accel_nodes: the limit of extent; lo and hi of the box around all triangles;
// from 7 the words of each structure; at 13 and 14 the place and length of the list in `leaves` of
// planes without end, which are in no cell.
#define CELLS_HEADER 16u

typedef struct {
  float r[3], n[3], f[3];  // rcp_d, o_near and o_far of RayOne, by axis
  int far;
  float begin, end;  // its interval in the scene's box, which is empty if end is less
} CellRay;

EK_FN CellRay cell_ray(Geometry geometry, const RayOne* ray, const Hit* hit) {
  global const float* header = (global const float*)geometry.nodes;
  CellRay c;
  c.r[0] = ray->rcp_d.x; c.r[1] = ray->rcp_d.y; c.r[2] = ray->rcp_d.z;
  c.n[0] = ray->o_near.x; c.n[1] = ray->o_near.y; c.n[2] = ray->o_near.z;
  c.f[0] = ray->o_far.x; c.f[1] = ray->o_far.y; c.f[2] = ray->o_far.z;
  c.far = !(ray->extent <= header[0]);
  c.begin = c.far ? -INFINITY : 0.0f;
  c.end = c.far ? INFINITY : hit->t;
  for (uint k = 0; k < 3; ++k) {
    const float lo = header[1 + k], hi = header[4 + k];
    c.begin = shape_max_one(c.begin, ((c.r[k] < 0.0f ? hi : lo) - c.n[k]) * c.r[k]);
    c.end = shape_min_one(c.end, ((c.r[k] < 0.0f ? lo : hi) - c.f[k]) * c.r[k]);
  }
  return c;
}

// The two sides of a plane along a ray: the t at which the first ends, and that at which the second
// begins. falls: 1 if the ray comes from above, or from in front
typedef struct {
  float first_end, second_begin;
  int falls;
} CellParts;

// 1 if a cell that begins there cannot hold the closest hit.
EK_FN int is_behind(const CellRay* c, const Hit* hit, float begin) { return (!c->far) & (begin > hit->t); }

// The cells that a ray is still to visit, the next one last, and its interval in each.
typedef struct {
  uint cell[EK_STACK_SIZE];
  float begin[EK_STACK_SIZE], end[EK_STACK_SIZE];
  uint size;
} CellStack;

// Pushes a cell if `counts` is 1; otherwise the next one takes its place.
EK_FN void cell_push(CellStack* stack, uint cell, float begin, float end, int counts) {
  stack->cell[stack->size] = cell;
  stack->begin[stack->size] = begin;
  stack->end[stack->size] = end;
  stack->size += (uint)counts;
}
// Takes the next cell that does not lie behind the hit; returns 0 if there is none.
EK_FN int cell_pop(CellStack* stack, const CellRay* c, const Hit* hit, uint* cell, float* begin, float* end) {
  do {
    if (stack->size == 0) return 0;
    *begin = stack->begin[--stack->size];
  } while (is_behind(c, hit, *begin));
  *cell = stack->cell[stack->size];
  *end = stack->end[stack->size];
  return 1;
}

// Tests the triangles of a list; returns 1 if one settles an any-hit query.
EK_FN int try_list(Geometry geometry, const RayOne* ray, uint first, uint count, const int any_hit, Hit* hit) {
  for (uint i = 0; i < count; ++i) {
    if (try_triangle(geometry, ray, geometry.leaves[first + i], any_hit, hit)) return 1;
  }
  return 0;
}

#endif
