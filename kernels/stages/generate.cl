// SPDX-License-Identifier: Apache-2.0
#include "stages/generate.h"

EK_FN_ONCE void generate_run(constant Frame* frame, global const uint* pixels, global uint* state, global float* film_slots,
                             global const float* filter_table, uint first, uint count) {
  stage_generate(frame, pixels, state, film_slots, filter_table, first, count);
}

kernel void generate(constant Frame* frame, global const uint* pixels, global uint* path_state, global uint* counts,
                     global uint* queue_rays, global float* film_slots, global const float* filter_table) {
  const uint begin = EK_CHUNK_INDEX * EK_CHUNK;
  const uint count = begin < frame->path_count ? min(frame->path_count - begin, (uint)EK_CHUNK) : 0u;
#if EK_CHUNKED
  counts[4 * EK_CHUNK_INDEX + 1] = count;
#else
  if (EK_ENTRY == 0) counts[1] = count;
  if (EK_ENTRY < count) queue_rays[EK_CHUNK + EK_ENTRY] = EK_ENTRY;  // the half of odd depths
#endif
  generate_run(frame, pixels, chunk_state(path_state) + EK_ENTRY, film_slots, filter_table, begin + EK_ENTRY,
               own_count(count));
}
