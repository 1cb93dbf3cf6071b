// SPDX-License-Identifier: Apache-2.0
#include "stages/shade.h"

EK_FN_ONCE Survivors shade_run(constant Frame* frame, SceneData scene, LightData light_data, global uint* state,
                               global float* film_slots, global const uint* queue, uint count, uint depth) {
  return stage_shade(frame, scene, light_data, state, film_slots, queue, count, depth);
}

kernel void shade(constant Frame* frame, global uint* path_state, global uint* counts, global const uint* queue_rays,
                  global float* film_slots, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS, uint depth) {
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
#if !EK_CHUNKED
  if (get_global_id(0) == 0) counts[(depth + 1) & 1] = counts[2] = 0;  // for compact.cl
#endif
  const Survivors survivors = shade_run(frame, scene, light_data, chunk_state(path_state), film_slots,
                                        depth_queue(queue_rays, depth), depth_count(counts, depth), depth);
  (void)survivors;
#if EK_CHUNKED
  counts[4 * EK_CHUNK_INDEX + ((depth + 1) & 1)] = survivors.next;
  counts[4 * EK_CHUNK_INDEX + 2] = survivors.shadow;
#endif
}
