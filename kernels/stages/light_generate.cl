// SPDX-License-Identifier: Apache-2.0
#include "stages/light/generate.h"

kernel void light_generate(constant Frame* frame, global const uint* pixels, global uint* path_state, global uint* counts,
                           global uint* queue_rays, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS) {
#if EK_HAS_light_paths
  const uint begin = EK_CHUNK_INDEX * EK_CHUNK;
  const uint count = begin < frame->path_count ? min(frame->path_count - begin, (uint)EK_CHUNK) : 0u;
  begin_queue(counts, queue_rays, count);
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  const StageContext stage = {.frame = frame, .state = chunk_state(path_state) + EK_ENTRY};
  const PathSource source = {.pixels = pixels};
  stage_light_generate(stage, scene, light_data, source, begin + EK_ENTRY, own_count(count));
#endif
}
