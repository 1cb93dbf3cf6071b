// SPDX-License-Identifier: Apache-2.0
// Where a traversal of one ray finds the words of the ray.
//
// A GPU has few registers: with 72 for each work-item, 28 of the 64 warps of an SM fit, with 96
// only
// 20. The words that boxes need and those that triangles need are never needed at the same time. So
//     on
// devices with queues a ray lies in local memory; a traversal takes the ones from there before a
// run of nodes, and the others before each triangle. These loads are volatile, or else a compiler
// would keep in registers what they bring. Local memory also takes an index that varies, by which
// the axes of the triangle test find their words.
//
// Rays of programs with instances change on their way. They are in private memory, as all are on
// CPU devices.
#ifndef EK_RAY_MEMORY_H
#define EK_RAY_MEMORY_H
#include "traverse/ray.h"

#define EK_RAY_IN_LOCAL_MEMORY (EK_WIDTH == 1 && !EK_CHUNKED && !EK_HAS_instance)

#if EK_RAY_IN_LOCAL_MEMORY
// Words of a ray. Vectors are in the axes of the world.
enum {
  RAY_rcp_d = 0,
  RAY_o_near = 3,
  RAY_o_far = 6,
  RAY_o = 9,
  RAY_sx = 12,
  RAY_sy,
  RAY_extent,
  RAY_axis,  // as RayLanes
  RAY_origin_prim,
  RAY_target_prim,
  RAY_WORDS
};

// Those of one work-item: word i is at i * EK_WORK_GROUP, so that neighbours lie in different
// banks.
typedef volatile local uint* RayMemory;

// In a kernel, before EK_GEOMETRY: the words of its work-items.
#define EK_RAY_MEMORY local uint ray_memory[RAY_WORDS * EK_WORK_GROUP];
#define EK_OWN_RAY_MEMORY , ray_memory + get_local_id(0)

EK_FN float ray_word(RayMemory ray, uint word) { return as_float(ray[word * EK_WORK_GROUP]); }
EK_FN v3 ray_vector(RayMemory ray, uint word) {
  return V3(ray_word(ray, word), ray_word(ray, word + 1u), ray_word(ray, word + 2u));
}
EK_FN void ray_set_word(RayMemory ray, uint word, float x) { ray[word * EK_WORK_GROUP] = as_uint(x); }
EK_FN void ray_set_vector(RayMemory ray, uint word, v3 a) {
  ray_set_word(ray, word, a.x);
  ray_set_word(ray, word + 1u, a.y);
  ray_set_word(ray, word + 2u, a.z);
}

EK_FN void ray_memory_store(RayMemory memory, RayLanes ray) {
  ray_set_vector(memory, RAY_rcp_d, ray.rcp_d);
  ray_set_vector(memory, RAY_o_near, ray.o_near);
  ray_set_vector(memory, RAY_o_far, ray.o_far);
  ray_set_vector(memory, RAY_o, unpermute3(ray.p_o, ray.axis == 0.0f, ray.axis == 1.0f));
  ray_set_word(memory, RAY_sx, ray.sx);
  ray_set_word(memory, RAY_sy, ray.sy);
  ray_set_word(memory, RAY_extent, ray.extent);
  ray_set_word(memory, RAY_axis, ray.axis);
  ray_set_word(memory, RAY_origin_prim, as_float(ray.ends.origin_prim));
  ray_set_word(memory, RAY_target_prim, as_float(ray.ends.target_prim));
}

EK_FN RayBoxes ray_memory_boxes(RayMemory memory) {
  const RayBoxes boxes = {ray_vector(memory, RAY_rcp_d), ray_vector(memory, RAY_o_near), ray_vector(memory, RAY_o_far)};
  return boxes;
}

// The words for triangles.
EK_FN RayOne ray_memory_test(RayMemory memory) {
  const uint z = (uint)ray_word(memory, RAY_axis), x = z == 2u ? 0u : z + 1u, y = 3u - z - x;
  RayOne ray;
  ray.axis_x = 8u * x;
  ray.axis_z = 8u * z;
  ray.p_o = V3(ray_word(memory, RAY_o + x), ray_word(memory, RAY_o + y), ray_word(memory, RAY_o + z));
  ray.p_rcp_d = V3(ray_word(memory, RAY_rcp_d + x), ray_word(memory, RAY_rcp_d + y), ray_word(memory, RAY_rcp_d + z));
  ray.p_near_x = ray_word(memory, RAY_o_near + x);
  ray.p_near_y = ray_word(memory, RAY_o_near + y);
  ray.p_far_x = ray_word(memory, RAY_o_far + x);
  ray.p_far_y = ray_word(memory, RAY_o_far + y);
  ray.sx = ray_word(memory, RAY_sx);
  ray.sy = ray_word(memory, RAY_sy);
  ray.extent = ray_word(memory, RAY_extent);
  ray.origin_prim = as_uint(ray_word(memory, RAY_origin_prim));
  ray.instance_or_target = as_uint(ray_word(memory, RAY_target_prim));
  return ray;
}
#else
#define EK_RAY_MEMORY
#define EK_OWN_RAY_MEMORY
#endif

#endif
