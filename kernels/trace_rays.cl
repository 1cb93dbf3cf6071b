// SPDX-License-Identifier: Apache-2.0
// Rays of any origin through the production traversal, for `bench rays` and the tests.
//   rays  seven arrays of `stride` floats: origin x y z, direction x y z, t_max; at least 16 behind ray_count may be read
//   hits  four arrays of `stride` words: t, u, v, triangle; trace_any writes the first, 1 or 0
// A work-item traces EK_CHUNK rays.
#include "traverse.h"

#define TRACE_ARGUMENTS                                                                                              \
  constant Frame* frame, global const uint* accel_nodes, global const uint* accel_leaves,                           \
      global const Triangle* triangles, global const float* rays, global float* hits, uint ray_count, uint stride,  \
      uint coherent

EK_FN v3 trace_load3(global const float* p, uint stride) { return V3(load_f(p), load_f(p + stride), load_f(p + 2 * stride)); }

kernel void trace_closest(TRACE_ARGUMENTS) {
  const Geometry geometry = {accel_nodes, accel_leaves, triangles};
  const uint begin = (uint)get_global_id(0) * EK_CHUNK, end = min(begin + EK_CHUNK, ray_count);
  for (uint i = begin; i < end; i += EK_WIDTH) {
    const HitLanes hit = closest_hit(frame, geometry, trace_load3(rays + i, stride), trace_load3(rays + 3 * stride + i, stride),
                                     min(end - i, (uint)EK_WIDTH), coherent);
    store_f(hits + i, hit.t);
    store_f(hits + stride + i, hit.u);
    store_f(hits + 2 * stride + i, hit.v);
    store_f(hits + 3 * stride + i, AS_F(hit.triangle));
  }
}

kernel void trace_any(TRACE_ARGUMENTS) {
  const Geometry geometry = {accel_nodes, accel_leaves, triangles};
  const uint begin = (uint)get_global_id(0) * EK_CHUNK, end = min(begin + EK_CHUNK, ray_count);
  for (uint i = begin; i < end; i += EK_WIDTH) {
    const vi blocked = occluded(frame, geometry, trace_load3(rays + i, stride), trace_load3(rays + 3 * stride + i, stride),
                                load_f(rays + 6 * stride + i), min(end - i, (uint)EK_WIDTH), coherent);
    store_f(hits + i, blocked ? (vf)(1.0f) : (vf)(0.0f));
  }
}
