// SPDX-License-Identifier: Apache-2.0
// Rays of any origin for packets, in the smallest trees: kept until there are many, sorted by where they begin and by direction, and
// traced sixteen neighbours of that order at a time. Those agree on the axis of the triangle test, so that its corners need no
// choice by lane, and mostly on the signs of the direction, so that the packet has bounds on each axis: it meets the boxes and
// triangles on one side of the scene, not all of them. And they mostly begin at one wall, if the scene is a room. The order
// shows in no hit.
#ifndef EK_TRAVERSE_SORTED_H
#define EK_TRAVERSE_SORTED_H
#include "traverse/wide/packet.h"

#if EK_SORTS
// Side of the scene's box that the origin is nearest to (6 of 8), axis of the direction's longest component (3 of 4), and octant.
#define SORTED_CLASSES 256u

// Rows that wait, in the order of coming.
typedef struct {
  float origin_x[EK_ROWS] EK_ROWS_ALIGNED, origin_y[EK_ROWS] EK_ROWS_ALIGNED, origin_z[EK_ROWS] EK_ROWS_ALIGNED;
  float dir_x[EK_ROWS] EK_ROWS_ALIGNED, dir_y[EK_ROWS] EK_ROWS_ALIGNED, dir_z[EK_ROWS] EK_ROWS_ALIGNED;
  float t_max[EK_ROWS] EK_ROWS_ALIGNED;
  uint left[EK_ROWS] EK_ROWS_ALIGNED, goal[EK_ROWS] EK_ROWS_ALIGNED;
#if EK_HAS_opacity
  uint key[EK_ROWS] EK_ROWS_ALIGNED, index[EK_ROWS] EK_ROWS_ALIGNED;
#endif
  uint class_of[EK_ROWS] EK_ROWS_ALIGNED, row[EK_ROWS] EK_ROWS_ALIGNED;
  uint count;
} SortedRays;

// Puts `count` rays (at most EK_WIDTH) of row `row` and those behind it to the others.
EK_FN void sorted_add(constant Frame* frame, SortedRays* s, uint row, v3 origin, v3 dir, vf t_max, RayEnds ends, OpacityKey key,
                      uint count) {
  const uint at = s->count;
  *(vf_unaligned*)(s->origin_x + at) = origin.x;
  *(vf_unaligned*)(s->origin_y + at) = origin.y;
  *(vf_unaligned*)(s->origin_z + at) = origin.z;
  *(vf_unaligned*)(s->dir_x + at) = dir.x;
  *(vf_unaligned*)(s->dir_y + at) = dir.y;
  *(vf_unaligned*)(s->dir_z + at) = dir.z;
  *(vf_unaligned*)(s->t_max + at) = t_max;
  *(vu_unaligned*)(s->left + at) = ends.left;
  *(vu_unaligned*)(s->goal + at) = ends.goal;
#if EK_HAS_opacity
  *(vu_unaligned*)(s->key + at) = key.key;
  *(vu_unaligned*)(s->index + at) = key.index;
#endif
  const v3 size = abs3(dir);
  const vu none = (vu)(0u);
  const vi longest_x = (size.x > size.y) & (size.x > size.z), longest_y = size.y > size.z;
  const vu axis = longest_x ? (vu)(16u) : longest_y ? (vu)(8u) : none;
  const vu octant = (dir.x < 0.0f ? (vu)(1u) : none) + (dir.y < 0.0f ? (vu)(2u) : none) + (dir.z < 0.0f ? (vu)(4u) : none);
  const v3 away = sub3(origin, splat3(frame->scene_center));
  const float4 half_size = frame->scene_half;
  const v3 share = V3(abs_f(away.x) * (1.0f / half_size.x), abs_f(away.y) * (1.0f / half_size.y), abs_f(away.z) * (1.0f / half_size.z));
  const vi side_x = (share.x > share.y) & (share.x > share.z), side_y = share.y > share.z;
  const vf side = side_x ? away.x : side_y ? away.y : away.z;
  const vu wall = (side_x ? (vu)(128u) : side_y ? (vu)(64u) : none) + (side < 0.0f ? (vu)(32u) : none);
  *(vu_unaligned*)(s->class_of + at) = wall + axis + octant;
  *(vu_unaligned*)(s->row + at) = (vu)(row) + LANE_INDEX;
  s->count = at + count;
}

// The order by class, in `order`; [count, count + EK_WIDTH) repeats an entry.
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
