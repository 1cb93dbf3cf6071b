// SPDX-License-Identifier: Apache-2.0
#include "stages/generate.h"

kernel void generate(constant Frame* frame, global const uint* pixels, global uint* path_state, global uint* counts,
                     global uint* queue_rays, global float* film_slots,
                     global const float* filter_table EK_CAMERA_ARGUMENTS EK_LOG_ARGUMENT) {
  const uint begin = EK_CHUNK_INDEX * EK_CHUNK;
  const uint count = begin < frame->path_count ? min(frame->path_count - begin, (uint)EK_CHUNK) : 0u;
  begin_queue(counts, queue_rays, count);
  const PathSource source = {pixels, filter_table EK_CAMERA_DATA};
  const StageContext stage = {.frame = frame,
                              .state = chunk_state(path_state) + EK_ENTRY,
                              .film = {film_slots, frame->film_stride} EK_STAGE_LOG};
  stage_generate(stage, source, begin + EK_ENTRY, own_count(count));
}
