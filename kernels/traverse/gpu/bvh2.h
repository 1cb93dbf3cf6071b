// SPDX-License-Identifier: Apache-2.0
// Layout `bvh2`, for GPU devices: binary nodes of 16 words that hold both children's boxes.
//   words 0-5, 6-11  lo x y z, hi x y z of child 0 and 1; a missing child has lo = +inf, hi = -inf
//   words 12, 13     child: index of its node, or bit 31 | (count - 1) << 28 | first entry of its triangles in `leaves`
#ifndef EK_TRAVERSE_BVH2_H
#define EK_TRAVERSE_BVH2_H
#include "traverse/hit.h"

// Where the ray enters child `p`; *end is where it leaves it.
EK_FN float bvh2_interval(global const float* p, const RayOne* ray, float* end) {
  const float near_x = ((ray->rx < 0.0f ? p[3] : p[0]) - ray->nx) * ray->rx;
  const float near_y = ((ray->ry < 0.0f ? p[4] : p[1]) - ray->ny) * ray->ry;
  const float near_z = ((ray->rz < 0.0f ? p[5] : p[2]) - ray->nz) * ray->rz;
  const float far_x = ((ray->rx < 0.0f ? p[0] : p[3]) - ray->fx) * ray->rx;
  const float far_y = ((ray->ry < 0.0f ? p[1] : p[4]) - ray->fy) * ray->ry;
  const float far_z = ((ray->rz < 0.0f ? p[2] : p[5]) - ray->fz) * ray->rz;
  *end = shape_min_one(shape_min_one(far_x, far_y), far_z);
  return shape_max_one(shape_max_one(shape_max_one(near_x, near_y), near_z), 0.0f);
}

EK_FN int traverse_bvh2(Geometry geometry, const RayOne* given, const int any_hit, Hit* hit) {
#if EK_HAS_instance
  RayOne placed = *given;
  RayOne* ray = &placed;
#else
  const RayOne* ray = given;
#endif
  uint stack[EK_STACK_SIZE];
  uint waiting = 0, current = 0;
  for (;;) {
    EK_COUNT_STEP(hit);
#if EK_HAS_instance
    if (current == INSTANCE_EXIT) {
      ray_exit(ray);
    } else if (is_instance_child(current)) {
      const uint place = current & ~INSTANCE_CHILD;
      ray_enter(geometry.scene.instances, ray, place);
      stack[waiting++] = INSTANCE_EXIT;
      current = geometry.scene.instances[place].root;
      continue;
    } else
#endif
    if (!(current & 0x80000000u)) {
      global const uint* node = geometry.nodes + (size_t)current * 16;
      float end0, end1;
      const float begin0 = bvh2_interval((global const float*)node, ray, &end0);
      const float begin1 = bvh2_interval((global const float*)node + 6, ray, &end1);
      const int in0 = begin0 <= shape_min_one(end0, hit->t), in1 = begin1 <= shape_min_one(end1, hit->t);
      if (in0 | in1) {
        const int first0 = in0 & ((!in1) | (begin0 <= begin1));
        if (in0 & in1) stack[waiting++] = node[first0 ? 13 : 12];
        current = node[first0 ? 12 : 13];
        continue;
      }
    } else {
      const uint first = current & 0x0fffffffu, count = ((current >> 28) & 7u) + 1u;
      for (uint i = 0; i < count; ++i) {
        if (try_triangle(geometry, ray, geometry.leaves[first + i], any_hit, hit)) return 1;
      }
    }
    if (waiting == 0) return 0;
    current = stack[--waiting];
  }
}

#endif
