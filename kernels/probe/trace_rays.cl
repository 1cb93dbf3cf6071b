// SPDX-License-Identifier: Apache-2.0
// Rays of any origin through the production traversal, for `bench rays` and the tests.
//   rays  ten arrays of `stride` words: origin x y z, direction x y z, t_max, the triangles that
//         the ray leaves and goes to (EK_NO_HIT: none), and its time (EK_HAS_moving_surface); at
//         least 16 behind ray_count may be read
//   hits  four arrays of `stride` words: t, u, v, triangle; and with EK_HAS_instance a fifth:
//         instance; trace_any writes the first, 1 or 0. In a program that counts (hit.h), u and v
//         are numbers of triangle tests and of steps
// A work-item traces EK_CHUNK rays. With EK_HAS_opacity each ray has decisions of its own; with
// EK_HAS_culling those of trace_closest are camera rays.
#include "traverse/traverse.h"

#define TRACE_ARGUMENTS                                                                                              \
  constant Frame* frame, EK_GEOMETRY_ARGUMENTS, global const float* rays, global float* hits, uint ray_count, \
      uint stride, uint coherent

EK_FN v3 trace_load3(global const float* p, uint stride) { return V3(load_f(p), load_f(p + stride), load_f(p + 2 * stride)); }

// The rays from `first` on, which are row `row` of `rows`.
EK_FN TracedRays trace_rays(global const float* rays, uint stride, uint first, uint row, uint rows, uint coherent) {
  global const float* p = rays + first + row;
  const TracedRays traced = {.row = row,
                             .count = min(rows - row, (uint)EK_WIDTH),
                             .coherent = (int)coherent,
                             .origin = trace_load3(p, stride),
                             .dir = trace_load3(p + 3 * stride, stride),
                             .t_max = load_f(p + 6 * stride),
                             .ends = {AS_U(load_f(p + 7 * stride)), AS_U(load_f(p + 8 * stride))},
                             .key = opacity_key(hash_bits((vu)(first + row) + LANE_INDEX), (vu)(0u), 1u, 0u),
                             .time = EK_HAS_moving_surface ? load_f(p + 9 * stride) : (vf)(0.0f)};
  return traced;
}

EK_FN void trace_run(constant Frame* frame, Geometry geometry, global const float* rays, global float* hits, uint ray_count,
                     uint stride, uint coherent, const int any_hit) {
  const uint begin = (uint)get_global_id(0) * EK_CHUNK, end = min(begin + EK_CHUNK, ray_count);
  Tracing tracing;
  for (uint first = begin; first < end; first += EK_ROWS) {
    const uint rows = min(end - first, (uint)EK_ROWS);
    tracing_clear(&tracing);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      TracedRays traced = trace_rays(rays, stride, first, row, rows, coherent);
      if (!any_hit) traced.t_max = EK_INFINITY;
      tracing_begin(frame, geometry, &tracing, traced, any_hit);
    }
    tracing_finish(frame, geometry, &tracing, any_hit);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      const HitLanes hit = closest_result(&tracing, row);
      global float* p = hits + first + row;
      store_f(p, !any_hit ? hit.t : any_result(&tracing, row) ? (vf)(1.0f) : (vf)(0.0f));
      if (!any_hit | EK_COUNT) {
        store_f(p + stride, hit.u);
        store_f(p + 2 * stride, hit.v);
      }
      if (!any_hit) store_f(p + 3 * stride, AS_F(hit.triangle));
      if (EK_HAS_instance & !any_hit) store_f(p + 4 * stride, AS_F(hit.instance));
    }
  }
}

kernel void trace_closest(TRACE_ARGUMENTS) {
  EK_RAY_MEMORY
  Geometry geometry = EK_GEOMETRY;
  cull_backs(&geometry, 1);
  trace_run(frame, geometry, rays, hits, ray_count, stride, coherent, 0);
}

kernel void trace_any(TRACE_ARGUMENTS) {
  EK_RAY_MEMORY
  const Geometry geometry = EK_GEOMETRY;
  trace_run(frame, geometry, rays, hits, ray_count, stride, coherent, 1);
}
