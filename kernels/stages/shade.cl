// SPDX-License-Identifier: Apache-2.0
#include "stages/shade.h"

kernel void shade(constant Frame* frame, global uint* path_state, global uint* counts, global const uint* queue_rays,
                  global float* film_slots, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS EK_LOG_ARGUMENT,
                  uint depth) {
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  const StageContext stage = {.frame = frame,
                              .state = chunk_state(path_state),
                              .queue = depth_queue(queue_rays, depth),
                              .film = {film_slots, frame->film_stride} EK_STAGE_LOG};
#if EK_CHUNKED
  const Survivors survivors = stage_shade(stage, scene, light_data, depth_count(counts, depth), depth);
  counts[4 * EK_CHUNK_INDEX + ((depth + 1) & 1)] = survivors.paths;
  counts[4 * EK_CHUNK_INDEX + 2] = survivors.shadow_rays;
#else
  if (get_global_id(0) == 0) {  // for compact.cl
    counts[(depth + 1) & 1] = counts[2] = 0;
    if (EK_SHADOW_PATHS) counts[3] = 0;
  }
  stage_shade(stage, scene, light_data, depth_count(counts, depth), depth);
#endif
}
