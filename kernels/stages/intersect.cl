// SPDX-License-Identifier: Apache-2.0
#include "stages/intersect.h"

kernel void intersect(constant Frame* frame, global uint* path_state, global const uint* counts,
                      global const uint* queue_rays, EK_GEOMETRY_ARGUMENTS, uint depth) {
  EK_RAY_MEMORY
  const Geometry geometry = EK_GEOMETRY;
  const StageContext stage = {
      .frame = frame, .state = chunk_state(path_state), .queue = depth_queue(queue_rays, depth)};
  stage_intersect(stage, geometry, depth_count(counts, depth), depth);
}
