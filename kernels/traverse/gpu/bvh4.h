// SPDX-License-Identifier: Apache-2.0
// Layout `bvh4`, for GPU devices: nodes of 16 words with four children, whose boxes are quantised.
//   words 0-3    origin and exponents of the boxes (quantised.h); highest byte of word 3: bit k,
//                there is a child k
//   words 4-9    planes lo x, hi x, lo y, hi y, lo z, hi z: a byte per child, that of child 0
//                lowest
//   words 10, 11 unused
//   words 12-15  child: index of its node, or bit 31 | (count - 1) << 28 | first entry of its
//                triangles in `leaves`. The children come smallest first, because an any-hit ray
//                takes the last first, and the largest is the likeliest to be hit.
#ifndef EK_TRAVERSE_BVH4_H
#define EK_TRAVERSE_BVH4_H
#include "traverse/quantised.h"

#define BVH4_LEAF 0x80000000u
#define BVH4_NONE 0xffffffffu  // the begin of a child that is not met: behind all others

// Puts the nearer of two children first.
EK_FN void bvh4_order(uint2* a, uint2* b) {
  const uint2 first = a->x <= b->x ? *a : *b, second = a->x <= b->x ? *b : *a;
  *a = first;
  *b = second;
}

// Takes the next entry that begins at or before t from the stack; returns 0 if there is none.
EK_FN int bvh4_pop(const uint* stack, const float* begins, uint* size, const int any_hit, float t, uint* current) {
  do {
    if (*size == 0) return 0;
    --*size;
  } while (!any_hit && begins[*size] > t);
  *current = stack[*size];
  return 1;
}

EK_FN int traverse_bvh4(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  uint stack[EK_STACK_SIZE];
  float begins[EK_STACK_SIZE];  // where the ray enters the entries of the stack; for closest hits only
  uint stack_size = 0, current = 0;
  for (;;) {
    const RayBoxes boxes = ray_boxes(geometry, ray);
    while (!(current & BVH4_LEAF)) {
      EK_COUNT_STEP(hit);
      global const uint4* node = (global const uint4*)geometry.nodes + (size_t)current * 4;
      const uint4 frame = node[0], planes = node[1], children = node[3];
      const uint2 z = node[2].xy;
      float4 end;
      const float4 begin = quantised_boxes(frame, planes.xy, planes.zw, z, &boxes, &end);
      const int4 in = begin <= min_plane(end, (float4)(hit->t));
      const uint there = frame.w >> 24;
      const int in0 = (in.x != 0) & ((there & 1u) != 0), in1 = (in.y != 0) & ((there & 2u) != 0);
      const int in2 = (in.z != 0) & ((there & 4u) != 0), in3 = (in.w != 0) & ((there & 8u) != 0);
      if (any_hit) {
        const uint before = stack_size;
        if (in0) stack[stack_size++] = children.x;
        if (in1) stack[stack_size++] = children.y;
        if (in2) stack[stack_size++] = children.z;
        if (in3) stack[stack_size++] = children.w;
        if (stack_size != before) {
          current = stack[--stack_size];
          continue;
        }
      } else {
        // Begins are not negative, so their bits sort as they do.
        uint2 c0 = (uint2)(in0 ? as_uint(begin.x) : BVH4_NONE, children.x);
        uint2 c1 = (uint2)(in1 ? as_uint(begin.y) : BVH4_NONE, children.y);
        uint2 c2 = (uint2)(in2 ? as_uint(begin.z) : BVH4_NONE, children.z);
        uint2 c3 = (uint2)(in3 ? as_uint(begin.w) : BVH4_NONE, children.w);
        bvh4_order(&c0, &c1);
        bvh4_order(&c2, &c3);
        bvh4_order(&c0, &c2);
        bvh4_order(&c1, &c3);
        bvh4_order(&c1, &c2);
        if (c0.x != BVH4_NONE) {
          if (c3.x != BVH4_NONE) {
            stack[stack_size] = c3.y;
            begins[stack_size++] = as_float(c3.x);
          }
          if (c2.x != BVH4_NONE) {
            stack[stack_size] = c2.y;
            begins[stack_size++] = as_float(c2.x);
          }
          if (c1.x != BVH4_NONE) {
            stack[stack_size] = c1.y;
            begins[stack_size++] = as_float(c1.x);
          }
          current = c0.y;
          continue;
        }
      }
      if (!bvh4_pop(stack, begins, &stack_size, any_hit, hit->t, &current)) return 0;
    }
    EK_COUNT_STEP(hit);
    const uint first = current & 0x0fffffffu, count = ((current >> 28) & 7u) + 1u;
    for (uint i = 0; i < count; ++i) {
      if (try_triangle(geometry, ray, geometry.leaves[first + i], any_hit, hit)) return 1;
    }
    if (!bvh4_pop(stack, begins, &stack_size, any_hit, hit->t, &current)) return 0;
  }
}

#endif
