// SPDX-License-Identifier: Apache-2.0
#include "stages/shadow.h"

EK_FN_ONCE void shadow_run(constant Frame* frame, Geometry geometry, global uint* state, global float* film_slots,
                           global const uint* queue, uint count, uint depth) {
  stage_shadow(frame, geometry, state, film_slots, queue, count, depth);
}

kernel void shadow(constant Frame* frame, global uint* path_state, global const uint* counts,
                   global const uint* queue_shadow, EK_GEOMETRY_ARGUMENTS, global float* film_slots, uint depth) {
  const Geometry geometry = EK_GEOMETRY;
  shadow_run(frame, geometry, chunk_state(path_state), film_slots, queue_shadow + EK_ENTRY,
             own_count(counts[4 * EK_CHUNK_INDEX + 2]), depth);
}
