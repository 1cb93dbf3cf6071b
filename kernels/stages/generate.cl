// SPDX-License-Identifier: Apache-2.0
#include "stages/generate.h"

kernel void generate(constant Frame* frame, global const uint* pixels, global uint* path_state, global uint* counts,
                     global uint* queue_rays, global float* film_slots, global const float* filter_table) {
  const uint first = EK_CHUNK_INDEX * EK_CHUNK;
  const uint count = first < frame->path_count ? min(frame->path_count - first, (uint)EK_CHUNK) : 0u;
#if EK_CHUNKED
  counts[4 * EK_CHUNK_INDEX + 1] = count;
#else
  const uint slot = (uint)get_global_id(0);
  if (slot == 0) counts[1] = count;
  if (slot < count) queue_rays[EK_CHUNK + slot] = slot;  // the half of odd depths
#endif
  stage_generate(frame, pixels, chunk_state(path_state), film_slots, filter_table, first, count);
}
