// SPDX-License-Identifier: Apache-2.0
// Layout `bvh8`, for CPU devices: one ray against eight boxes, or eight triangles, in explicit vectors.
//   node, 64 words: [0, 48) planes lo x, hi x, lo y, hi y, lo z, hi z of the children, eight each; a missing child has
//     lo = +inf, hi = -inf. [48, 56) children, smallest first: index of the node, or bit 31 | index of the block.
//     [56, 64) word i, bits 3k .. 3k + 2: the child that is i-th from far to near for rays of octant k (bit 0: x < 0, ...);
//     bits 24 .. 31 of word 56 of the root: binary digits of the number of triangles
//   block, 80 words: [0, 72) corners a x, a y, a z, b x, ..., c z of eight triangles; [72, 80) their indices. An unused
//     triangle is NaN, and its index EK_NO_HIT.
#ifndef EK_TRAVERSE_BVH8_H
#define EK_TRAVERSE_BVH8_H
#include "hit.h"

#define BVH8_LEAF 0x80000000u

EK_FN float8 bvh8_load(global const float* p) { return *(global const float8*)p; }

// Child k with the place where the ray enters it: as integers they sort by that place, which is not negative.
EK_FN ulong bvh8_entry(const float* begin, global const uint* children, uint k) {
  return (ulong)as_uint(begin[k]) << 32 | children[k];
}
EK_FN ulong min_entry(ulong a, ulong b) { return a < b ? a : b; }
EK_FN ulong max_entry(ulong a, ulong b) { return a > b ? a : b; }

// Puts the children of `bits` (not 0) on the stack, farthest first, except the nearest, which it returns. A ray meets one or
// two children of a node as a rule: a branch for each small number is cheaper than sorting.
EK_FN uint bvh8_push_sorted(float8 begins, global const uint* children, uint bits, ulong* stack, uint* waiting) {
  uint k = lowest_bit(bits);
  bits &= bits - 1;
  if (bits == 0) return children[k];
  float begin[8] __attribute__((aligned(32)));
  *(float8*)begin = begins;
  const ulong e0 = bvh8_entry(begin, children, k);
  k = lowest_bit(bits);
  bits &= bits - 1;
  const ulong e1 = bvh8_entry(begin, children, k);
  const ulong a = min_entry(e0, e1), b = max_entry(e0, e1);
  uint top = *waiting;
  if (bits == 0) {
    stack[top] = b;
    *waiting = top + 1;
    return (uint)a;
  }
  k = lowest_bit(bits);
  bits &= bits - 1;
  const ulong e2 = bvh8_entry(begin, children, k);
  if (bits == 0) {
    const ulong rest = max_entry(a, e2);
    stack[top] = max_entry(b, rest);
    stack[top + 1] = min_entry(b, rest);
    *waiting = top + 2;
    return (uint)min_entry(a, e2);
  }
  // Insertion into the stack's end.
  const uint base = top;
  stack[top++] = b;
  stack[top++] = a;
  ulong next = e2;
  for (;;) {
    uint at = top++;
    for (; at > base && stack[at - 1] < next; --at) stack[at] = stack[at - 1];
    stack[at] = next;
    if (bits == 0) break;
    k = lowest_bit(bits);
    bits &= bits - 1;
    next = bvh8_entry(begin, children, k);
  }
  *waiting = top - 1;
  return (uint)stack[top - 1];
}

// The same without order, for any-hit queries: the children come smallest first, and the largest is tried first.
EK_FN uint bvh8_push(global const uint* children, uint bits, ulong* stack, uint* waiting) {
  while (bits & (bits - 1)) {
    stack[(*waiting)++] = children[lowest_bit(bits)];
    bits &= bits - 1;
  }
  return children[lowest_bit(bits)];
}

// Whether the tree is so small that any rays share most of the way: measured, packets win up to some 2000 triangles.
EK_FN int bvh8_is_small(Geometry geometry) { return geometry.nodes[56] >> 24 <= 11u; }

// Which triangles of a block a ray hits.
EK_FN TriangleHit_block bvh8_found(global const float* block, const RayOne* ray, uint x, uint y, uint z) {
  Corners_block corners;
  corners.ax = bvh8_load(block + x); corners.ay = bvh8_load(block + y); corners.az = bvh8_load(block + z);
  corners.bx = bvh8_load(block + 24 + x); corners.by = bvh8_load(block + 24 + y); corners.bz = bvh8_load(block + 24 + z);
  corners.cx = bvh8_load(block + 48 + x); corners.cy = bvh8_load(block + 48 + y); corners.cz = bvh8_load(block + 48 + z);
  return triangle_hit_block(ray, corners);
}

// Those of the block's triangles `bits` (not 0) that do not let the ray pass. In lanes, where there are eight: one question for
// all of them.
EK_FN uint bvh8_stopping(Geometry geometry, global const float* block, const RayOne* ray, TriangleHit_block found, uint bits) {
  uint passable = 0;
  for (uint rest = bits; rest != 0; rest &= rest - 1) {
    const uint k = lowest_bit(rest);
    passable |= may_be_passed(geometry.scene, as_uint(block[72 + k])) ? 1u << k : 0u;
  }
  if (passable == 0) return bits;
#if EK_WIDTH == 1
  float u[8] __attribute__((aligned(32))), v[8] __attribute__((aligned(32)));
  *(float8*)u = found.u;
  *(float8*)v = found.v;
  for (uint rest = passable; rest != 0; rest &= rest - 1) {
    const uint k = lowest_bit(rest);
    if (passes_one(geometry, ray, as_uint(block[72 + k]), u[k], v[k])) bits &= ~(1u << k);
  }
  return bits;
#else
  const uint8 ids = as_uint8(bvh8_load(block + 72)), valid = ids == EK_NO_HIT ? (uint8)(0u) : ids;
#if EK_WIDTH == 8
  const vu triangle = valid;
  const vf u = found.u, v = found.v;
#else
  const vu triangle = (vu)(valid, valid);
  const vf u = (vf)(found.u, found.u), v = (vf)(found.v, found.v);
#endif
  return bits & ~(passable & mask_bits(passes(geometry.scene, triangle, u, v, ray_key_one(ray))));
#endif
}

// Tests a block. returns 1 if that settles an any-hit query.
EK_FN int bvh8_block(Geometry geometry, global const float* block, const RayOne* ray, uint x, uint y, uint z, const int any_hit,
                     Hit* hit) {
  const TriangleHit_block found = bvh8_found(block, ray, x, y, z);
  uint bits = any_hit ? mask_bits8(found.hit & (found.t < hit->t)) : mask_bits8(found.hit & (found.t <= hit->t));
  if (EK_HAS_opacity && bits != 0) bits = bvh8_stopping(geometry, block, ray, found, bits);
  if (any_hit) return bits != 0;
  if (bits != 0) {
    float t[8] __attribute__((aligned(32))), u[8] __attribute__((aligned(32))), v[8] __attribute__((aligned(32)));
    *(float8*)t = found.t;
    *(float8*)u = found.u;
    *(float8*)v = found.v;
    do {
      const uint k = lowest_bit(bits);
      bits &= bits - 1;
      const uint triangle = as_uint(block[72 + k]);
      if (is_closer(hit, t[k], triangle)) {
        hit->t = t[k];
        hit->u = u[k];
        hit->v = v[k];
        hit->triangle = triangle;
      }
    } while (bits != 0);
  }
  return 0;
}

EK_FN int traverse_bvh8(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  ulong stack[EK_STACK_SIZE];
  uint waiting = 0, current = 0;
  // Offsets of the planes that the ray meets first, and of the corners' planes in the axes of the triangle test.
  const uint near_x = ray->rx < 0.0f ? 8u : 0u, near_y = ray->ry < 0.0f ? 24u : 16u, near_z = ray->rz < 0.0f ? 40u : 32u;
  const uint far_x = near_x ^ 8u, far_y = near_y ^ 8u, far_z = near_z ^ 8u;
  const uint z = 8u * (uint)ray->axis, x = z == 16u ? 0u : z + 8u, y = x == 16u ? 0u : x + 8u;
  for (;;) {
    if (!(current & BVH8_LEAF)) {
      global const float* node = (global const float*)geometry.nodes + (size_t)current * 64;
      const float8 begin_x = (bvh8_load(node + near_x) - ray->nx) * ray->rx;
      const float8 begin_y = (bvh8_load(node + near_y) - ray->ny) * ray->ry;
      const float8 begin_z = (bvh8_load(node + near_z) - ray->nz) * ray->rz;
      const float8 end_x = (bvh8_load(node + far_x) - ray->fx) * ray->rx;
      const float8 end_y = (bvh8_load(node + far_y) - ray->fy) * ray->ry;
      const float8 end_z = (bvh8_load(node + far_z) - ray->fz) * ray->rz;
      const float8 begin = shape_max_block(shape_max_block(begin_x, begin_y), shape_max_block(begin_z, (float8)(0.0f)));
      const float8 end = shape_min_block(shape_min_block(end_x, end_y), shape_min_block(end_z, (float8)(hit->t)));
      const uint bits = mask_bits8(begin <= end);
      if (bits != 0) {
        global const uint* children = (global const uint*)node + 48;
        current = any_hit ? bvh8_push(children, bits, stack, &waiting)
                          : bvh8_push_sorted(begin, children, bits, stack, &waiting);
        continue;
      }
    } else {
      global const float* block = (global const float*)geometry.leaves + (size_t)(current & ~BVH8_LEAF) * 80;
      if (bvh8_block(geometry, block, ray, x, y, z, any_hit, hit)) return 1;
    }
    ulong next;
    do {
      if (waiting == 0) return 0;
      next = stack[--waiting];
    } while (!any_hit & (as_float((uint)(next >> 32)) > hit->t));
    current = (uint)next;
  }
}

#endif
