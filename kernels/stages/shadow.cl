// SPDX-License-Identifier: Apache-2.0
// Stage `shadow`.   From: pending shadow rays of this depth.
// Adds what a shadow ray carries to its path's film slots, if nothing is in the way.
#include "traverse.h"
#include "wavefront.h"

kernel void shadow(constant Frame* frame, global uint* path_state, global const uint* counts,
                   global const uint* queue_shadow, global const uint* accel_nodes, global const uint* accel_leaves,
                   global const Triangle* triangles, global float* film_slots, uint depth) {
  global uint* state = chunk_state(path_state);
  const Geometry geometry = {accel_nodes, accel_leaves, triangles};
  const uint count = counts[4 * EK_CHUNK_INDEX + 2];
  EK_FOR_EACH(slot, count, queue_shadow) {
    const uint lanes = EK_CHUNKED ? min(count - slot, (uint)EK_WIDTH) : 1u;
    const vi blocked = occluded(frame, geometry, state_3(state, FIELD_shadow_origin_x, slot),
                                state_3(state, FIELD_shadow_dir_x, slot), state_f(state, FIELD_shadow_t, slot), lanes,
                                depth == 1);
    film_add(film_slots, frame->film_stride, FILM_r, (LANE_INDEX < (vu)(lanes)) & !blocked,
             state_u(state, FIELD_shadow_path, slot), state_3(state, FIELD_shadow_r, slot));
  }
}
