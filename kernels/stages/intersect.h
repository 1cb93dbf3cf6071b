// SPDX-License-Identifier: Apache-2.0
// Stage `intersect`.   From: paths of this depth.   To: the same paths, with their hits.
// Finds the closest hit of each path's ray. Reads origin, dir, and the triangle that was hit before; writes hit_*; no shading, and no
// randomness but opacity's.
#ifndef EK_STAGE_INTERSECT_H
#define EK_STAGE_INTERSECT_H
#include "traverse/traverse.h"
#include "stages/wavefront.h"

EK_FN_ONCE void stage_intersect(constant Frame* frame, Geometry geometry, global uint* state, global const uint* queue, uint count,
                                uint depth) {
  Tracing tracing;
  EK_FOR_EACH_ROWS(first, count, queue) {
    const uint rows = EK_CHUNKED ? min(count - first, (uint)EK_ROWS) : 1u;
    tracing_clear(&tracing);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      RayEnds ends = unknown_ends();
      ends.left = state_u(state, FIELD_hit_triangle, first + row);
      OpacityKey key = {(vu)(0u), (vu)(0u)};
      if (EK_HAS_opacity)
        key = opacity_key(state_u(state, FIELD_key, first + row), state_u(state, FIELD_index, first + row), depth, 0u);
      tracing_begin(frame, geometry, &tracing, row, state_3(state, FIELD_origin_x, first + row),
                    state_3(state, FIELD_dir_x, first + row), EK_INFINITY, ends, key, min(rows - row, (uint)EK_WIDTH), depth == 1, 0);
    }
    tracing_finish(frame, geometry, &tracing, 0);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      const HitLanes hit = closest_result(&tracing, row);
      state_set_f(state, FIELD_hit_t, first + row, hit.t);
      state_set_f(state, FIELD_hit_u, first + row, hit.u);
      state_set_f(state, FIELD_hit_v, first + row, hit.v);
      state_set_u(state, FIELD_hit_triangle, first + row, hit.triangle);
#if EK_HAS_instance
      state_set_u(state, FIELD_hit_instance, first + row, hit.instance);
#endif
    }
  }
}

#endif
