// SPDX-License-Identifier: Apache-2.0
#include "stages/intersect.h"

EK_FN_ONCE void intersect_run(constant Frame* frame, Geometry geometry, global uint* state, global const uint* queue, uint count,
                              uint depth) {
  stage_intersect(frame, geometry, state, queue, count, depth);
}

kernel void intersect(constant Frame* frame, global uint* path_state, global const uint* counts,
                      global const uint* queue_rays, EK_GEOMETRY_ARGUMENTS, uint depth) {
  const Geometry geometry = EK_GEOMETRY;
  intersect_run(frame, geometry, chunk_state(path_state), depth_queue(queue_rays, depth), depth_count(counts, depth), depth);
}
