// SPDX-License-Identifier: Apache-2.0
#include "stages/light/splat.h"

kernel void splat(constant Frame* frame, global uint* path_state, global const uint* counts,
                  global const uint* queue_shadow, EK_GEOMETRY_ARGUMENTS, global uint* splats, global uint* splat_counts, uint depth) {
#if EK_HAS_light_paths
  EK_RAY_MEMORY
  const Geometry geometry = EK_GEOMETRY;
  const StageContext stage = {.frame = frame, .state = chunk_state(path_state), .queue = queue_shadow + EK_ENTRY};
  const RecordList list = {splats, splat_counts, frame->splat_capacity};
  stage_splat(stage, geometry, list, shadow_count(counts));
#endif
}
