// SPDX-License-Identifier: Apache-2.0
#include "stages/shadow.h"

kernel void shadow(constant Frame* frame, global uint* path_state, global const uint* counts,
                   global const uint* queue_shadow, EK_GEOMETRY_ARGUMENTS, global float* film_slots EK_LOG_ARGUMENT,
                   uint depth) {
  EK_RAY_MEMORY
  const Geometry geometry = EK_GEOMETRY;
  const StageContext stage = {.frame = frame,
                              .state = chunk_state(path_state),
                              .queue = queue_shadow + EK_ENTRY,
                              .film = {film_slots, frame->film_stride} EK_STAGE_LOG};
  stage_shadow(stage, geometry, shadow_count(counts), depth);
}
