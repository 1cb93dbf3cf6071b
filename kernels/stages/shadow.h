// SPDX-License-Identifier: Apache-2.0
// Stage `shadow`.   From: pending shadow rays of this depth.
// Adds what a shadow ray carries to its path's film slots, if nothing is in the way.
#ifndef EK_STAGE_SHADOW_H
#define EK_STAGE_SHADOW_H
#include "traverse/traverse.h"
#include "stages/wavefront.h"

EK_FN_ONCE void stage_shadow(constant Frame* frame, Geometry geometry, global uint* state, global float* film_slots,
                             global const uint* queue, uint count, uint depth) {
  Tracing tracing;
  EK_FOR_EACH_ROWS(first, count, queue) {
    const uint rows = EK_CHUNKED ? min(count - first, (uint)EK_ROWS) : 1u;
    tracing_clear(&tracing);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      RayEnds ends = unknown_ends();
      if (!EK_HAS_instance) ends.left = state_u(state, FIELD_shadow_left, first + row);
      if (EK_HAS_area & !EK_HAS_instance) ends.goal = state_u(state, FIELD_shadow_goal, first + row);
      OpacityKey key = {(vu)(0u), (vu)(0u)};
      if (EK_HAS_opacity) {
        key.key = state_u(state, FIELD_shadow_key, first + row);
        key.index = state_u(state, FIELD_shadow_index, first + row);
      }
      tracing_begin(frame, geometry, &tracing, row, shadow_state_3(state, FIELD_shadow_origin_x, first + row),
                    shadow_state_3(state, FIELD_shadow_dir_x, first + row), state_f(state, FIELD_shadow_t, first + row),
                    ends, key, min(rows - row, (uint)EK_WIDTH), depth == 1, 1);
    }
    tracing_finish(frame, geometry, &tracing, 1);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      const vi visible = (LANE_INDEX < (vu)(min(rows - row, (uint)EK_WIDTH))) & !any_result(&tracing, row);
      film_add_light(film_slots, frame->film_stride, visible, state_u(state, FIELD_shadow_path, first + row), depth,
                     (EK_HAS_nested_media & EK_HAS_scattered) ? state_u(state, FIELD_shadow_crossed, first + row) : (vu)(0u),
                     EK_HAS_light_group ? state_u(state, FIELD_shadow_group, first + row) : (vu)(0u),
                     shadow_state_3(state, FIELD_shadow_r, first + row));
    }
  }
}

#endif
