// SPDX-License-Identifier: Apache-2.0
// Layouts `bvh16` and `bvh8`, for CPU devices: a ray is tested against all boxes of a node, or the
// eight triangles of a leaf, in explicit vectors. With W = 16 or 8 boxes per node, their words are:
//   node       8 W words
//     [0, 6 W)    planes lo x, hi x, lo y, hi y, lo z, hi z of the children, W each; a missing
//                 child has lo = +inf, hi = -inf
//     [6 W, 7 W)  children, smallest first: the index of a node, or bit 31 | the index of a leaf; 0
//                 where a child is missing
//     [7 W, 8 W)  word i, bits b k .. b k + b - 1 with b = log2 W: the child that is i-th from far
//                 to near for rays of octant k (bit 0: x < 0, ...)
//   leaf8      80 words
//     [0, 72)     corners a x, a y, a z, b x, ..., c z of eight triangles; an unused triangle is
//                 NaN
//     [72, 80)    their indices; EK_NO_HIT for an unused one
// Over time, in the tree of the triangles that move (motion_tree.h), a node or a leaf is a row of
// records, one for each step of the shutter's time, and its index that of the first. Within a step
// planes and corners go straight.
//   node       14 W words
//     [0, 8 W)     as above, at the begin of the step; a missing child has the largest finite
//                  numbers as its planes
//     [8 W, 14 W)  how far the planes move in the step, in the same order
//   leaf8      160 words
//     [0, 80)      as above, at the begin of the step
//     [80, 152)    how far the corners move in the step: the rounded differences to the next pose
//     [152, 160)   of each triangle the first record in `pose_triangles`
#ifndef EK_TRAVERSE_WIDE_H
#define EK_TRAVERSE_WIDE_H
#include "lanes/compact.h"
#include "traverse/hit.h"

#define WIDE_LEAF 0x80000000u
#define WIDE_NOTHING 0xffffffffu  // no child, although it has the bit of leaves
#define WIDE_NODE_WORDS (8u * EK_NODE_WIDTH)
#define WIDE_MOVING_NODE_WORDS (14u * EK_NODE_WIDTH)
#define LEAF8_WORDS 80u
#define LEAF8_MOVING_WORDS 160u
#define LEAF8_TRIANGLES 72u  // offset of their indices

#if EK_LAYOUT_bvh16
typedef float16 wf;
typedef uint16 wu;
#define wide_bits mask_bits16
#define wide_words as_uint16
#define wide_floats as_float16
#define wide_permute permute16
#define wide_append append16
typedef uint16_unaligned wu_unaligned;
#else
typedef float8 wf;
typedef uint8 wu;
#define wide_bits mask_bits8
#define wide_words as_uint8
#define wide_floats as_float8
#define wide_permute permute8
#define wide_append append8
typedef uint8_unaligned wu_unaligned;
#endif

EK_FN wf wide_load(global const float* p) { return *(global const wf*)p; }
EK_FN wf wide_min(wf a, wf b) { return a < b ? a : b; }
EK_FN wf wide_max(wf a, wf b) { return a > b ? a : b; }

EK_FN global const float* wide_node(Geometry geometry, uint node) {
  return (global const float*)geometry.nodes +
         (size_t)node * (EK_OVER_TIME(geometry) ? WIDE_MOVING_NODE_WORDS : WIDE_NODE_WORDS);
}
EK_FN global const float* wide_leaf8(Geometry geometry, uint child) {
  return (global const float*)geometry.leaves +
         (size_t)(child & ~WIDE_LEAF) * (EK_OVER_TIME(geometry) ? LEAF8_MOVING_WORDS : LEAF8_WORDS);
}

// A row of a node's planes, at the ray's time. Whether the sum is contracted does not matter,
// because the planes of boxes that move lie outside of all that they bound by more than any
// rounding takes them (host/accel/layouts/pose_boxes.cpp).
EK_FN wf wide_planes(Geometry geometry, global const float* planes, const RayOne* ray) {
#pragma OPENCL FP_CONTRACT ON
#if EK_HAS_moving_surface
  if (EK_OVER_TIME(geometry)) return wide_load(planes + WIDE_NODE_WORDS) * ray->share + wide_load(planes);
#endif
  return wide_load(planes);
}

// The record at a child that a ray needs.
EK_FN uint wide_record(Geometry geometry, uint child, const RayOne* ray) {
#if EK_HAS_moving_surface
  if (EK_OVER_TIME(geometry)) return child + ray->step;
#endif
  return child;
}

// Fetches what is at a child (wide_record), in a tree that is larger than the caches. For marks
// that are no child it fetches the root: fetching where there is no memory costs a walk of the page
// tables each time.
EK_FN void wide_prefetch(Geometry geometry, uint child) {
#if EK_LARGE_TREE && EK_CPU
  child = (child == WIDE_NOTHING) | (EK_HAS_instance & (child == INSTANCE_EXIT)) ? 0u : child;
  if (EK_HAS_instance && is_instance_child(child)) {
    EK_PREFETCH(geometry.scene.instances + (child & ~INSTANCE_CHILD));
    EK_PREFETCH((global const char*)(geometry.scene.instances + (child & ~INSTANCE_CHILD)) + 64);
    return;
  }
  global const char* p = child & WIDE_LEAF ? (global const char*)wide_leaf8(geometry, child)
                                           : (global const char*)wide_node(geometry, child);
  EK_PREFETCH(p);
  EK_PREFETCH(p + 64);
  EK_PREFETCH(p + 128);
  EK_PREFETCH(p + 192);
  EK_PREFETCH(p + 256);
  if (EK_OVER_TIME(geometry)) {
    EK_PREFETCH(p + 320);
    EK_PREFETCH(p + 384);
    EK_PREFETCH(p + 448);
  }
#if EK_LAYOUT_bvh16
  if (EK_OVER_TIME(geometry)) p += 192;
  global const char* rest = child & WIDE_LEAF ? p : p + 320;  // a leaf has no more words
  EK_PREFETCH(rest);
  EK_PREFETCH(rest + 64);
  EK_PREFETCH(rest + 128);
  if (EK_OVER_TIME(geometry)) {
    EK_PREFETCH(rest + 192);
    EK_PREFETCH(rest + 256);
    EK_PREFETCH(rest + 320);
  }
#endif
#endif
}

// The begin and the end of the ray's interval in each child.
EK_FN wf wide_begin(Geometry geometry, global const float* node, const RayOne* ray) {
  const wf x = (wide_planes(geometry, node + ray->near_x, ray) - ray->o_near.x) * ray->rcp_d.x,
           y = (wide_planes(geometry, node + ray->near_y, ray) - ray->o_near.y) * ray->rcp_d.y,
           z = (wide_planes(geometry, node + ray->near_z, ray) - ray->o_near.z) * ray->rcp_d.z;
  return wide_max(wide_max(x, y), wide_max(z, (wf)(0.0f)));
}
EK_FN wf wide_end(Geometry geometry, global const float* node, const RayOne* ray) {
  const wf x = (wide_planes(geometry, node + (ray->near_x ^ EK_NODE_WIDTH), ray) - ray->o_far.x) * ray->rcp_d.x,
           y = (wide_planes(geometry, node + (ray->near_y ^ EK_NODE_WIDTH), ray) - ray->o_far.y) * ray->rcp_d.y,
           z = (wide_planes(geometry, node + (ray->near_z ^ EK_NODE_WIDTH), ray) - ray->o_far.z) * ray->rcp_d.z;
  return wide_min(wide_min(x, y), wide_min(z, (wf)(ray->t)));
}

#if EK_HAS_shape
#if EK_HAS_sphere
// The lanes whose box may hold a sphere that the ray meets. A lane is false only where the line
// passes the middle of the box by more than half its width and the errors of arithmetic. Let v lead
// from the origin to the middle, (sx, sy, 1) be the line's direction, r the radius and u = 2^-24.
// shapes/sphere.h accepts lines up to r + 30 u |v| + 10 u r from the middle: the products with the
// sphere's matrix shift the origin by 12 u |v| and turn the line by as much, and the point next to
// the middle is rounded by 4 u |v|. What is computed here is off by 6 u |v| + 3 u |middle| and a
// share of 12 u. |v| is at most sqrt(3) extent, and |middle| is at most that and |o|. So a margin
// of 68 u extent + 3 u |o| + 22 u r is enough. o_near and o_far are apart by 32 u extent + u |o| or
// more (ray.h); the margin is four times that, and 2^-17 r.
EK_FN int8 leaf8_near_spheres(global const float* leaf8, const RayOne* ray) {
  const uint x = ray->axis_x, z = ray->axis_z, y = 24u - x - z;
#define WIDE_MIDDLE(axis) (0.5f * (*(global const float8*)(leaf8 + axis) + *(global const float8*)(leaf8 + 24u + axis)) - ray->p_o.axis)
  const float8 cz = WIDE_MIDDLE(z), cx = WIDE_MIDDLE(x) - ray->sx * cz, cy = WIDE_MIDDLE(y) - ray->sy * cz;
#undef WIDE_MIDDLE
  const float8 across = cx * ray->sy - cy * ray->sx, square = (cx * cx + cy * cy) + across * across;
  const float8 half_width = 0.5f * (*(global const float8*)(leaf8 + 24) - *(global const float8*)leaf8);
  const float8 least = half_width * (1.0f + 0x1p-17f) + 4.0f * as_float(as_uint(ray->o_near.x - ray->o_far.x) & 0x7fffffffu);
  return !(square > (least * least) * ((1.0f + ray->sx * ray->sx) + ray->sy * ray->sy));
}
#endif

// The shapes of a leaf whose boxes the ray meets, as bits. A third corner that is NaN marks a
// shape; its sign is set for a sphere, which counts only if the ray may meet it. *triangles: 1 if
// the leaf has triangles, too
EK_FN uint leaf8_shapes(global const float* leaf8, const RayOne* ray, int* triangles) {
  const float8 lo_x = *(global const float8*)leaf8, third_x = *(global const float8*)(leaf8 + 48);
  const uint here = mask_bits8(lo_x == lo_x), shapes = mask_bits8(third_x != third_x) & here;
  *triangles = shapes != here;
  if (shapes == 0) return 0;
  const uint near_x = ray->rcp_d.x < 0.0f ? 24u : 0u, near_y = ray->rcp_d.y < 0.0f ? 32u : 8u, near_z = ray->rcp_d.z < 0.0f ? 40u : 16u;
#define WIDE_SHAPE(at, o, r) ((*(global const float8*)(leaf8 + (at)) - ray->o) * ray->r)
  const float8 begin_x = WIDE_SHAPE(near_x, o_near.x, rcp_d.x), begin_y = WIDE_SHAPE(near_y, o_near.y, rcp_d.y),
               begin_z = WIDE_SHAPE(near_z, o_near.z, rcp_d.z);
  const float8 end_x = WIDE_SHAPE(24u - near_x, o_far.x, rcp_d.x), end_y = WIDE_SHAPE(40u - near_y, o_far.y, rcp_d.y),
               end_z = WIDE_SHAPE(56u - near_z, o_far.z, rcp_d.z);
#undef WIDE_SHAPE
  const float8 zero = (float8)(0.0f), t = (float8)(ray->t);
  const float8 begin_xy = begin_x > begin_y ? begin_x : begin_y, begin_0 = begin_z > zero ? begin_z : zero;
  const float8 end_xy = end_x < end_y ? end_x : end_y, end_t = end_z < t ? end_z : t;
  const float8 begin = begin_xy > begin_0 ? begin_xy : begin_0, end = end_xy < end_t ? end_xy : end_t;
#if EK_HAS_sphere
  const int8 mark = *(global const int8*)(leaf8 + 48);
  return shapes & mask_bits8((begin <= end) & ((mark >= 0) | leaf8_near_spheres(leaf8, ray)));
#else
  return shapes & mask_bits8(begin <= end);
#endif
}
#endif

// A ray at a leaf: x, y, z are the offsets of the axes of its triangle test.
typedef struct {
  Geometry geometry;
  const RayOne* ray;
  global const float* leaf8;
  uint x, y, z;
} Leaf8Visit;

EK_FN Leaf8Visit leaf8_visit(Geometry geometry, uint child, const RayOne* ray) {
  const uint x = ray->axis_x, z = ray->axis_z;
  const Leaf8Visit visit = {geometry, ray, wide_leaf8(geometry, wide_record(geometry, child, ray)), x, 24u - x - z, z};
  return visit;
}

// One axis of one corner of the eight triangles as it is stored, in the world: the triangles of an
// instance are moved there.
EK_FN float8 leaf8_corner(const Leaf8Visit* visit, uint offset, uint axis) {
  global const float* corner = visit->leaf8 + offset;
  const uint instance = ray_instance(visit->ray);
  if (EK_HAS_instance && instance != 0u) {
    global const float* m = (global const float*)(visit->geometry.scene.instances + (instance - 1u)) + axis / 2u;
    const float8 x = *(global const float8*)corner, y = *(global const float8*)(corner + 8), z = *(global const float8*)(corner + 16);
    return ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
  }
  return *(global const float8*)(corner + axis);
}

// The triangles at which the ray starts or ends, as bits; no shape is one of them.
EK_FN uint leaf8_ends(global const float* leaf8, const RayOne* ray, const int any_hit) {
  const uint8 triangles = *(global const uint8*)(leaf8 + LEAF8_TRIANGLES);
  if (!EK_HAS_instance && any_hit) return mask_bits8((triangles == (uint8)(ray->origin_prim)) | (triangles == (uint8)(ray_target(ray))));
  return mask_bits8(triangles == (uint8)(ray->origin_prim));
}

#define EK_VISITS 1
#include "traverse/wide/leaf8.h"
#if EK_LAYOUT_bvh16
#define EK_VISITS 2
#include "traverse/wide/leaf8.h"
#endif

// The children that are not missing, as bits.
EK_FN uint wide_there(global const uint* children) { return wide_bits(*(global const wu*)children != (wu)(0u)); }

// Child k, below the t at which the ray enters it. That t is not negative, so entries sort by it as
// integers.
EK_FN ulong wide_entry(const float* begin, global const uint* children, uint k) {
  return (ulong)as_uint(begin[k]) << 32 | children[k];
}

// Traces one ray alone; returns 1 if an any-hit query found something.
EK_FN int traverse_wide(Geometry geometry, const RayOne* given, const int any_hit, Hit* hit) {
  ulong stack[EK_STACK_SIZE];
  RayOne ray = *given;
  uint stack_size = 0, current = 0;
  for (;;) {
    if (EK_HAS_instance && current == INSTANCE_EXIT) {
      ray_exit(&ray);
      ray.t = hit->t;
    } else if (EK_HAS_instance && is_instance_child(current)) {
      const uint instance = current & ~INSTANCE_CHILD;
      ray_enter(geometry.scene.instances, &ray, instance);
      stack[stack_size++] = INSTANCE_EXIT;  // as an entry it begins at 0, so it is never culled
      current = geometry.scene.instances[instance].root;
      continue;
    } else if (!(current & WIDE_LEAF)) {
      global const float* node = wide_node(geometry, wide_record(geometry, current, &ray));
      global const uint* children = (global const uint*)node + 6 * EK_NODE_WIDTH;
      const wf begins = wide_begin(geometry, node, &ray);
      float begin[EK_NODE_WIDTH] __attribute__((aligned(64)));
      *(wf*)begin = begins;
      const uint base = stack_size;
      for (uint bits = wide_bits(begins <= wide_end(geometry, node, &ray)) & wide_there(children); bits != 0; bits &= bits - 1) {
        const ulong entry = wide_entry(begin, children, lowest_bit(bits));
        // This sorts the new entries at the end of the stack by insertion, the nearest last.
        uint at = stack_size++;
        if (!any_hit) {
          for (; at > base && stack[at - 1] < entry; --at) stack[at] = stack[at - 1];
        }
        stack[at] = entry;
      }
    } else {
      const Leaf8Visit visit = leaf8_visit(geometry, current, &ray);
      uint certain;
      for (uint bits = leaf8_pretest(&visit, &visit, any_hit, &certain); bits != 0; bits &= bits - 1) {
        const uint triangle = as_uint(visit.leaf8[LEAF8_TRIANGLES + lowest_bit(bits)]);
        if (try_triangle(geometry, &ray, triangle, any_hit, hit)) return 1;
      }
      ray.t = hit->t;
    }
    ulong next;
    do {
      if (stack_size == 0) return 0;
      next = stack[--stack_size];
    } while (!any_hit & (as_float((uint)(next >> 32)) > hit->t));
    current = (uint)next;
  }
}

#endif
