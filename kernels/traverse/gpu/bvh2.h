// SPDX-License-Identifier: Apache-2.0
// Layout `bvh2`, for GPU devices: binary nodes of 16 words that hold both children's boxes.
//   words 0-5, 6-11  lo x y z, hi x y z of child 0 and 1; a missing child has lo = +inf, hi = -inf
//   words 12, 13     child: index of its node, or bit 31 | (count - 1) << 28 | first entry of its
//                    triangles in `leaves`
//   word 14          over time: 0, or where a record for each pose begins, as an index of nodes;
//                    words 0-11 are the boxes at that pose, between two of which planes go straight
//                    (host/accel/layouts/bvh2_motion.cpp)
#ifndef EK_TRAVERSE_BVH2_H
#define EK_TRAVERSE_BVH2_H
#include "traverse/hit.h"

#define BVH2_LEAF 0x80000000u

// The t at which the ray enters a child's box; *end: the t at which it leaves it
EK_FN float bvh2_interval(float3 lo, float3 hi, const RayBoxes* ray, float* end) {
  const int falls_x = ray->rcp_d.x < 0.0f, falls_y = ray->rcp_d.y < 0.0f, falls_z = ray->rcp_d.z < 0.0f;
  const float near_x = ((falls_x ? hi.x : lo.x) - ray->o_near.x) * ray->rcp_d.x;
  const float near_y = ((falls_y ? hi.y : lo.y) - ray->o_near.y) * ray->rcp_d.y;
  const float near_z = ((falls_z ? hi.z : lo.z) - ray->o_near.z) * ray->rcp_d.z;
  const float far_x = ((falls_x ? lo.x : hi.x) - ray->o_far.x) * ray->rcp_d.x;
  const float far_y = ((falls_y ? lo.y : hi.y) - ray->o_far.y) * ray->rcp_d.y;
  const float far_z = ((falls_z ? lo.z : hi.z) - ray->o_far.z) * ray->rcp_d.z;
  *end = shape_min_one(shape_min_one(far_x, far_y), far_z);
  return shape_max_one(shape_max_one(shape_max_one(near_x, near_y), near_z), 0.0f);
}

EK_FN int traverse_bvh2(Geometry geometry, const RayOne* given, const int any_hit, Hit* hit) {
  RayOne in_mesh;  // the copy that changes when the ray enters an instance
  if (EK_HAS_instance) in_mesh = *given;
  const RayOne* ray = EK_HAS_instance ? &in_mesh : given;
  uint stack[EK_STACK_SIZE];
  uint stack_size = 0, current = 0;
  for (;;) {
    const RayBoxes boxes = ray_boxes(geometry, ray);
    while (!(current & BVH2_LEAF)) {
      EK_COUNT_STEP(hit);
      global const float4* node = (global const float4*)geometry.nodes + (size_t)current * 4;
      float4 a = node[0], b = node[1], c = node[2];
      const uint2 children = *(global const uint2*)(node + 3);
#if EK_HAS_moving_surface
      const uint poses = EK_OVER_TIME(geometry) ? ((global const uint*)(node + 3))[2] : 0u;
      if (poses != 0u) {
        global const float4* at = (global const float4*)geometry.nodes + (size_t)(poses + ray->step) * 4;
        a = at[0] + (at[4] - at[0]) * ray->share;
        b = at[1] + (at[5] - at[1]) * ray->share;
        c = at[2] + (at[6] - at[2]) * ray->share;
      }
#endif
      float end0, end1;
      const float begin0 = bvh2_interval(a.xyz, (float3)(a.w, b.x, b.y), &boxes, &end0);
      const float begin1 = bvh2_interval((float3)(b.z, b.w, c.x), c.yzw, &boxes, &end1);
      const int in0 = begin0 <= shape_min_one(end0, hit->t), in1 = begin1 <= shape_min_one(end1, hit->t);
      if (in0 | in1) {
        const int first0 = in0 & ((!in1) | (begin0 <= begin1));
        if (in0 & in1) stack[stack_size++] = first0 ? children.y : children.x;
        current = first0 ? children.x : children.y;
      } else {
        if (stack_size == 0) return 0;
        current = stack[--stack_size];
      }
    }
    EK_COUNT_STEP(hit);
    if (EK_HAS_instance && current == INSTANCE_EXIT) {
      ray_exit(&in_mesh);
    } else if (EK_HAS_instance && is_instance_child(current)) {
      const uint instance = current & ~INSTANCE_CHILD;
      ray_enter(geometry.scene.instances, &in_mesh, instance);
      stack[stack_size++] = INSTANCE_EXIT;
      current = geometry.scene.instances[instance].root;
      continue;
    } else {
      const uint first = current & 0x0fffffffu, count = ((current >> 28) & 7u) + 1u;
      for (uint i = 0; i < count; ++i) {
        if (try_triangle(geometry, ray, geometry.leaves[first + i], any_hit, hit)) return 1;
      }
    }
    if (stack_size == 0) return 0;
    current = stack[--stack_size];
  }
}

#endif
