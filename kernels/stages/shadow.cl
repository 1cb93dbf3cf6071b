// SPDX-License-Identifier: Apache-2.0
#include "stages/shadow.h"

kernel void shadow(constant Frame* frame, global uint* path_state, global const uint* counts,
                   global const uint* queue_shadow, EK_GEOMETRY_ARGUMENTS, global float* film_slots, uint depth) {
  const Geometry geometry = EK_GEOMETRY;
  stage_shadow(frame, geometry, chunk_state(path_state), film_slots, queue_shadow, counts[4 * EK_CHUNK_INDEX + 2], depth);
}
