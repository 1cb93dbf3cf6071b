// SPDX-License-Identifier: Apache-2.0
// Layouts `bvh16` and `bvh8`, for CPU devices: one ray against all boxes of a node, or eight triangles, in explicit vectors.
// With W = 16 or 8 boxes per node,
//   node, 8 W words: [0, 6 W) planes lo x, hi x, lo y, hi y, lo z, hi z of the children, W each; a missing child has
//     lo = +inf, hi = -inf. [6 W, 7 W) children, smallest first: index of the node, or bit 31 | index of the block; never 0
//     but where a child is missing. [7 W, 8 W) word i, bits b k .. b k + b - 1 with b = log2 W: the child that is i-th from
//     far to near for rays of octant k (bit 0: x < 0, ...)
//   block, 80 words: [0, 72) corners a x, a y, a z, b x, ..., c z of eight triangles; [72, 80) their indices. An unused
//     triangle is NaN, and its index EK_NO_HIT.
#ifndef EK_TRAVERSE_WIDE_H
#define EK_TRAVERSE_WIDE_H
#include "traverse/hit.h"

#define WIDE_LEAF 0x80000000u
#define WIDE_NODE_WORDS (8u * EK_NODE_WIDTH)
#define WIDE_BLOCK_WORDS 80u

#if EK_LAYOUT_bvh16
typedef float16 wf;
typedef uint16 wu;
#define wide_bits mask_bits16
#define wide_words as_uint16
#define wide_floats as_float16
#else
typedef float8 wf;
typedef uint8 wu;
#define wide_bits mask_bits8
#define wide_words as_uint8
#define wide_floats as_float8
#endif

EK_FN wf wide_load(global const float* p) { return *(global const wf*)p; }
EK_FN wf wide_min(wf a, wf b) { return a < b ? a : b; }
EK_FN wf wide_max(wf a, wf b) { return a > b ? a : b; }

EK_FN global const float* wide_node(Geometry geometry, uint node) {
  return (global const float*)geometry.nodes + (size_t)node * WIDE_NODE_WORDS;
}
EK_FN global const float* wide_block(Geometry geometry, uint child) {
  return (global const float*)geometry.leaves + (size_t)(child & ~WIDE_LEAF) * WIDE_BLOCK_WORDS;
}

// In a tree that is larger than the caches.
EK_FN void wide_prefetch(Geometry geometry, uint child) {
#if EK_LARGE_TREE && EK_BUILTIN(__builtin_prefetch)
#if EK_HAS_instance
  if (is_instance_child(child)) {
    __builtin_prefetch(geometry.scene.instances + (child & ~INSTANCE_CHILD));
    __builtin_prefetch((global const char*)(geometry.scene.instances + (child & ~INSTANCE_CHILD)) + 64);
    return;
  }
#endif
  global const char* p = child & WIDE_LEAF ? (global const char*)wide_block(geometry, child)
                                           : (global const char*)wide_node(geometry, child);
  __builtin_prefetch(p);
  __builtin_prefetch(p + 64);
  __builtin_prefetch(p + 128);
  __builtin_prefetch(p + 192);
  __builtin_prefetch(p + 256);
#if EK_LAYOUT_bvh16
  global const char* rest = child & WIDE_LEAF ? p : p + 320;  // a block has no more
  __builtin_prefetch(rest);
  __builtin_prefetch(rest + 64);
  __builtin_prefetch(rest + 128);
#endif
#endif
}

// Where the ray's interval in each child begins and ends.
EK_FN wf wide_begin(global const float* node, const RayOne* ray) {
  const wf x = (wide_load(node + ray->near_x) - ray->nx) * ray->rx, y = (wide_load(node + ray->near_y) - ray->ny) * ray->ry,
           z = (wide_load(node + ray->near_z) - ray->nz) * ray->rz;
  return wide_max(wide_max(x, y), wide_max(z, (wf)(0.0f)));
}
EK_FN wf wide_end(global const float* node, const RayOne* ray) {
  const wf x = (wide_load(node + (ray->near_x ^ EK_NODE_WIDTH)) - ray->fx) * ray->rx,
           y = (wide_load(node + (ray->near_y ^ EK_NODE_WIDTH)) - ray->fy) * ray->ry,
           z = (wide_load(node + (ray->near_z ^ EK_NODE_WIDTH)) - ray->fz) * ray->rz;
  return wide_min(wide_min(x, y), wide_min(z, (wf)(ray->t)));
}

#if EK_HAS_shape
#if EK_HAS_sphere
// Lanes whose box may hold a sphere that the ray meets: false only where the line passes the middle of the box by more than half its
// width and what arithmetic can err by. With v from the origin to the middle, the line's direction (sx, sy, 1), r the radius and u = 2^-24,
// shapes/sphere.h accepts lines up to r + 30 u |v| + 10 u r from the middle (the products with the sphere's matrix shift the origin by
// 12 u |v|, turn the line by as much, and the point next to the middle is rounded by 4 u |v|); what is computed here is off by
// 6 u |v| + 3 u |middle| and a share of 12 u. |v| is at most sqrt(3) reach, |middle| that and |o| more. So 68 u reach + 3 u |o| + 22 u r is
// enough; o_near and o_far are apart by 32 u reach + u |o| or more (ray.h), four times which is taken, and 2^-17 r.
EK_FN int8 wide_near_middle(global const float* block, const RayOne* ray) {
  const uint x = ray->axis_x, z = ray->axis_z, y = 24u - x - z;
#define WIDE_MIDDLE(axis) (0.5f * (*(global const float8*)(block + axis) + *(global const float8*)(block + 24u + axis)) - ray->p_o##axis)
  const float8 cz = WIDE_MIDDLE(z), cx = WIDE_MIDDLE(x) - ray->sx * cz, cy = WIDE_MIDDLE(y) - ray->sy * cz;
#undef WIDE_MIDDLE
  const float8 across = cx * ray->sy - cy * ray->sx, square = (cx * cx + cy * cy) + across * across;
  const float8 half_width = 0.5f * (*(global const float8*)(block + 24) - *(global const float8*)block);
  const float8 least = half_width * (1.0f + 0x1p-17f) + 4.0f * as_float(as_uint(ray->nx - ray->fx) & 0x7fffffffu);
  return !(square > (least * least) * ((1.0f + ray->sx * ray->sx) + ray->sy * ray->sy));
}
#endif

// The shapes of a block, marked by a third corner that is NaN, whose boxes the ray meets; of spheres, which have their sign set, those
// that it may meet. triangles: whether the block has others.
EK_FN uint wide_shapes(global const float* block, const RayOne* ray, int* triangles) {
  const float8 lo_x = *(global const float8*)block, third_x = *(global const float8*)(block + 48);
  const uint here = mask_bits8(lo_x == lo_x), shapes = mask_bits8(third_x != third_x) & here;
  *triangles = shapes != here;
  if (shapes == 0) return 0;
  const uint near_x = ray->rx < 0.0f ? 24u : 0u, near_y = ray->ry < 0.0f ? 32u : 8u, near_z = ray->rz < 0.0f ? 40u : 16u;
#define WIDE_SHAPE(at, o, r) ((*(global const float8*)(block + (at)) - ray->o) * ray->r)
  const float8 begin_x = WIDE_SHAPE(near_x, nx, rx), begin_y = WIDE_SHAPE(near_y, ny, ry), begin_z = WIDE_SHAPE(near_z, nz, rz);
  const float8 end_x = WIDE_SHAPE(24u - near_x, fx, rx), end_y = WIDE_SHAPE(40u - near_y, fy, ry),
               end_z = WIDE_SHAPE(56u - near_z, fz, rz);
#undef WIDE_SHAPE
  const float8 zero = (float8)(0.0f), t = (float8)(ray->t);
  const float8 begin_xy = begin_x > begin_y ? begin_x : begin_y, begin_0 = begin_z > zero ? begin_z : zero;
  const float8 end_xy = end_x < end_y ? end_x : end_y, end_t = end_z < t ? end_z : t;
  const float8 begin = begin_xy > begin_0 ? begin_xy : begin_0, end = end_xy < end_t ? end_xy : end_t;
#if EK_HAS_sphere
  const int8 mark = *(global const int8*)(block + 48);
  return shapes & mask_bits8((begin <= end) & ((mark >= 0) | wide_near_middle(block, ray)));
#else
  return shapes & mask_bits8(begin <= end);
#endif
}
#endif

// An axis of a corner of the eight triangles, at the ray's place if it is at one.
EK_FN float8 wide_corner(Geometry geometry, const RayOne* ray, global const float* block, uint offset, uint axis) {
#if EK_HAS_instance
  if (ray->instance != 0u) {
    global const float* m = (global const float*)(geometry.scene.instances + (ray->instance - 1u)) + axis / 2u;
    const float8 x = *(global const float8*)(block + offset), y = *(global const float8*)(block + offset + 8),
                 z = *(global const float8*)(block + offset + 16);
    return ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
  }
#endif
  return *(global const float8*)(block + offset + axis);
}

// Which of them are the ray's ends; no shape is.
EK_FN uint wide_ends(global const float* block, const RayOne* ray, const int any_hit) {
  const uint8 triangles = *(global const uint8*)(block + 72);
#if !EK_HAS_instance
  if (any_hit) return mask_bits8((triangles == (uint8)(ray->left)) | (triangles == (uint8)(ray->goal)));
#endif
  return mask_bits8(triangles == (uint8)(ray->left));
}

#define EK_BLOCKS 1
#include "traverse/wide/block.h"
#if EK_LAYOUT_bvh16
#define EK_BLOCKS 2
#include "traverse/wide/block.h"
#endif

// Children that are there: those that are missing are never met, whatever a ray's numbers have become.
EK_FN uint wide_there(global const uint* children) { return wide_bits(*(global const wu*)children != (wu)(0u)); }

// Child k with the place where the ray enters it: as integers they sort by that place, which is not negative.
EK_FN ulong wide_entry(const float* begin, global const uint* children, uint k) {
  return (ulong)as_uint(begin[k]) << 32 | children[k];
}

// One ray alone.
EK_FN int traverse_wide(Geometry geometry, const RayOne* given, const int any_hit, Hit* hit) {
  ulong stack[EK_STACK_SIZE];
  RayOne ray = *given;
  uint waiting = 0, current = 0;
  for (;;) {
#if EK_HAS_instance
    if (current == INSTANCE_EXIT) {
      ray_exit(&ray);
      ray.t = hit->t;
    } else if (is_instance_child(current)) {
      const uint place = current & ~INSTANCE_CHILD;
      ray_enter(geometry.scene.instances, &ray, place);
      stack[waiting++] = INSTANCE_EXIT;  // where it begins is 0
      current = geometry.scene.instances[place].root;
      continue;
    } else
#endif
    if (!(current & WIDE_LEAF)) {
      global const float* node = wide_node(geometry, current);
      global const uint* children = (global const uint*)node + 6 * EK_NODE_WIDTH;
      const wf begins = wide_begin(node, &ray);
      float begin[EK_NODE_WIDTH] __attribute__((aligned(64)));
      *(wf*)begin = begins;
      const uint base = waiting;
      for (uint bits = wide_bits(begins <= wide_end(node, &ray)) & wide_there(children); bits != 0; bits &= bits - 1) {
        const ulong entry = wide_entry(begin, children, lowest_bit(bits));
        // Insertion into the stack's end, nearest last.
        uint at = waiting++;
        if (!any_hit) {
          for (; at > base && stack[at - 1] < entry; --at) stack[at] = stack[at - 1];
        }
        stack[at] = entry;
      }
    } else {
      global const float* block = wide_block(geometry, current);
      uint sure;
      for (uint bits = wide_candidates(geometry, block, &ray, any_hit, &sure); bits != 0; bits &= bits - 1) {
        if (try_triangle(geometry, &ray, as_uint(block[72 + lowest_bit(bits)]), any_hit, hit)) return 1;
      }
      ray.t = hit->t;
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
