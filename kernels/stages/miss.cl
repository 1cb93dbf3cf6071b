// SPDX-License-Identifier: Apache-2.0
#include "stages/miss.h"

kernel void miss(constant Frame* frame, global uint* path_state, global const uint* counts,
                 global const uint* queue_rays, global float* film_slots, EK_SCENE_ARGUMENTS,
                 global const float4* environment_texels EK_LIGHT_PATH_ARGUMENTS EK_LOG_ARGUMENT, uint depth) {
  const SceneData scene = EK_SCENE_DATA;
  LightData lights;
  lights.environment_texels = environment_texels;
#if EK_HAS_light_paths
  lights.light_paths.emission_aim = emission_aim;
#endif
  const StageContext stage = {.frame = frame,
                              .state = chunk_state(path_state),
                              .queue = depth_queue(queue_rays, depth),
                              .film = {film_slots, frame->film_stride} EK_STAGE_LOG};
  stage_miss(stage, scene, lights, depth_count(counts, depth), depth);
}
