// SPDX-License-Identifier: Apache-2.0
#include "stages/light/shade.h"

kernel void light_shade(constant Frame* frame, global uint* path_state, global uint* counts, global const uint* queue_rays,
                        EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS, global const float* filter_table, uint depth) {
#if EK_HAS_light_paths
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  const StageContext stage = {.frame = frame, .state = chunk_state(path_state), .queue = depth_queue(queue_rays, depth)};
  clear_counts(counts, depth);
  store_survivors(counts, depth, stage_light_shade(stage, scene, light_data, filter_table, depth_count(counts, depth), depth));
#endif
}
