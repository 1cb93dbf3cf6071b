// SPDX-License-Identifier: Apache-2.0
#include "stages/miss.h"

EK_FN_ONCE void miss_run(constant Frame* frame, SceneData scene, global const float4* environment_texels, global uint* state,
                         global float* film_slots, global const uint* queue, uint count, uint depth) {
  stage_miss(frame, scene, environment_texels, state, film_slots, queue, count, depth);
}

kernel void miss(constant Frame* frame, global uint* path_state, global const uint* counts, global const uint* queue_rays,
                 global float* film_slots, EK_SCENE_ARGUMENTS, global const float4* environment_texels, uint depth) {
  const SceneData scene = EK_SCENE_DATA;
  miss_run(frame, scene, environment_texels, chunk_state(path_state), film_slots, depth_queue(queue_rays, depth),
           depth_count(counts, depth), depth);
}
