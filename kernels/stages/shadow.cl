// SPDX-License-Identifier: Apache-2.0
// Stage `shadow`.   From: pending shadow rays of this depth.
// Adds what a shadow ray carries to its path's film slots, if nothing is in the way.
#include "traverse.h"
#include "wavefront.h"

kernel void shadow(constant Frame* frame, global uint* path_state, global const uint* counts,
                   global const uint* queue_shadow, EK_GEOMETRY_ARGUMENTS, global float* film_slots, uint depth) {
  global uint* state = chunk_state(path_state);
  const Geometry geometry = EK_GEOMETRY;
  const uint count = counts[4 * EK_CHUNK_INDEX + 2];
  Tracing tracing;
  EK_FOR_EACH_ROWS(first, count, queue_shadow) {
    const uint rows = EK_CHUNKED ? min(count - first, (uint)EK_ROWS) : 1u;
    tracing_clear(&tracing);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      OpacityKey key = {(vu)(0u), (vu)(0u)};
      if (EK_HAS_opacity) {
        key.key = state_u(state, FIELD_shadow_key, first + row);
        key.index = state_u(state, FIELD_shadow_index, first + row);
      }
      any_begin(frame, geometry, &tracing, row, state_3(state, FIELD_shadow_origin_x, first + row),
                state_3(state, FIELD_shadow_dir_x, first + row), state_f(state, FIELD_shadow_t, first + row), key,
                min(rows - row, (uint)EK_WIDTH), depth == 1);
    }
    tracing_finish(geometry, &tracing, 1);
    for (uint row = 0; row < rows; row += EK_WIDTH) {
      const vi visible = (LANE_INDEX < (vu)(min(rows - row, (uint)EK_WIDTH))) & !any_result(&tracing, row);
      film_add(film_slots, frame->film_stride, FILM_r, visible, state_u(state, FIELD_shadow_path, first + row),
               state_3(state, FIELD_shadow_r, first + row));
    }
  }
}
