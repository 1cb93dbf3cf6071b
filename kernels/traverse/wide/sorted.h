// SPDX-License-Identifier: Apache-2.0
// Packets of rays of any origin, for the smallest trees. Rays are kept until there are many, sorted
// by where they begin and by direction, and traced as packets of neighbours in that order.
// Neighbours agree on the axis of the triangle test, so its corners need no selection by lane. They
// mostly agree on the signs of the direction, so the packet has bounds on each axis and meets the
// boxes and triangles on one side of the scene, not all of them. In a room they mostly begin at one
// wall. The order changes no hit.
#ifndef EK_TRAVERSE_SORTED_H
#define EK_TRAVERSE_SORTED_H
#include "traverse/wide/packet.h"

#if EK_SORTS
// A class is the side of the scene's box that the origin is nearest to (6 of 8), the axis of the
// direction's longest component (3 of 4), and the octant.
#define SORTED_CLASSES 256u

// The rays that wait, in the order in which they came.
typedef struct {
  float origin_x[EK_ROWS] EK_ROWS_ALIGNED, origin_y[EK_ROWS] EK_ROWS_ALIGNED, origin_z[EK_ROWS] EK_ROWS_ALIGNED;
  float dir_x[EK_ROWS] EK_ROWS_ALIGNED, dir_y[EK_ROWS] EK_ROWS_ALIGNED, dir_z[EK_ROWS] EK_ROWS_ALIGNED;
  float t_max[EK_ROWS] EK_ROWS_ALIGNED;
  uint origin_prim[EK_ROWS] EK_ROWS_ALIGNED, target_prim[EK_ROWS] EK_ROWS_ALIGNED;
#if EK_HAS_opacity
  uint key[EK_ROWS] EK_ROWS_ALIGNED, index[EK_ROWS] EK_ROWS_ALIGNED;
#endif
  uint class_of[EK_ROWS] EK_ROWS_ALIGNED, row[EK_ROWS] EK_ROWS_ALIGNED;
  uint count;
} SortedRays;

// Adds rays to those that wait.
EK_FN void sorted_add(constant Frame* frame, SortedRays* s, TracedRays rays) {
  const uint at = s->count;
  const v3 origin = rays.origin, dir = rays.dir;
  *(vf_unaligned*)(s->origin_x + at) = origin.x;
  *(vf_unaligned*)(s->origin_y + at) = origin.y;
  *(vf_unaligned*)(s->origin_z + at) = origin.z;
  *(vf_unaligned*)(s->dir_x + at) = dir.x;
  *(vf_unaligned*)(s->dir_y + at) = dir.y;
  *(vf_unaligned*)(s->dir_z + at) = dir.z;
  *(vf_unaligned*)(s->t_max + at) = rays.t_max;
  *(vu_unaligned*)(s->origin_prim + at) = rays.ends.origin_prim;
  *(vu_unaligned*)(s->target_prim + at) = rays.ends.target_prim;
#if EK_HAS_opacity
  *(vu_unaligned*)(s->key + at) = rays.key.key;
  *(vu_unaligned*)(s->index + at) = rays.key.index;
#endif
  const v3 size = abs3(dir);
  const vu none = (vu)(0u);
  const vi longest_x = (size.x > size.y) & (size.x > size.z), longest_y = size.y > size.z;
  const vu axis = longest_x ? (vu)(16u) : longest_y ? (vu)(8u) : none;
  const vu octant = (dir.x < 0.0f ? (vu)(1u) : none) + (dir.y < 0.0f ? (vu)(2u) : none) + (dir.z < 0.0f ? (vu)(4u) : none);
  const v3 away = sub3(origin, splat3(frame->scene_center));
  const float4 half_size = frame->scene_half;
  const v3 share = V3(abs_f(away.x) * div_f(1.0f, half_size.x), abs_f(away.y) * div_f(1.0f, half_size.y), abs_f(away.z) * div_f(1.0f, half_size.z));
  const vi side_x = (share.x > share.y) & (share.x > share.z), side_y = share.y > share.z;
  const vf side = side_x ? away.x : side_y ? away.y : away.z;
  const vu wall = (side_x ? (vu)(128u) : side_y ? (vu)(64u) : none) + (side < 0.0f ? (vu)(32u) : none);
  *(vu_unaligned*)(s->class_of + at) = wall + axis + octant;
  *(vu_unaligned*)(s->row + at) = (vu)(rays.row) + LANE_INDEX;
  s->count = at + rays.count;
}

// Writes the order by class to `order`, of which [count, count + EK_WIDTH) repeats an entry.
EK_FN void sorted_order(const SortedRays* s, uint* order) {
  uint next[SORTED_CLASSES] = {0};
  for (uint i = 0; i < s->count; ++i) ++next[s->class_of[i]];
  uint sum = 0;
  for (uint k = 0; k < SORTED_CLASSES; ++k) {
    const uint size = next[k];
    next[k] = sum;
    sum += size;
  }
  for (uint i = 0; i < s->count; ++i) order[next[s->class_of[i]]++] = i;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) order[s->count + lane] = order[0];
}

EK_FN vf sorted_f(const float* p, const uint* order) {
  float x[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) x[lane] = p[order[lane]];
  return *(const vf*)x;
}
#endif

#endif
