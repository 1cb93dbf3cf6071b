// SPDX-License-Identifier: Apache-2.0
// Stage `compact`, on GPU devices; CPU devices pack the survivors in place, in stage shade.
// From: paths of this depth.   To: queue_rays of the next depth, queue_shadow.
// Work-groups count their survivors in local memory and reserve places with one atomic each. The
// order in the queues is not deterministic, and nothing depends on it.
#include "stages/wavefront.h"

kernel void compact(global uint* path_state, global uint* counts, global uint* queue_rays, global uint* queue_shadow,
                    uint depth) {
#if !EK_CHUNKED
  // Paths of the next depth, shadow rays, and with EK_SHADOW_PATHS paths with shadow rays.
  local uint group_count[2 + EK_SHADOW_PATHS], group_base[2 + EK_SHADOW_PATHS];
  const uint entry = (uint)get_global_id(0);
  const uint count = counts[depth & 1];
  const uint next_half = (depth + 1) & 1;
  if (get_local_id(0) < 2 + EK_SHADOW_PATHS) group_count[get_local_id(0)] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint slot = entry < count ? queue_rays[(depth & 1) * EK_CHUNK + entry] : 0u;
  const uint next = entry < count ? path_state[FIELD_next * EK_STRIDE + slot] : 0u;
  uint place[2] = {0, 0};
  if (next & 1) place[0] = atomic_inc(&group_count[0]);
  if (next >> 1) place[1] = atomic_inc(&group_count[1 + EK_SHADOW_PATHS]);
  if (EK_SHADOW_PATHS && next >> 1) atomic_add(&group_count[1], popcount(next >> 1));
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) {
    group_base[0] = atomic_add(&counts[next_half], group_count[0]);
    for (uint i = 1; i < 2 + EK_SHADOW_PATHS; ++i) group_base[i] = atomic_add(&counts[1 + i], group_count[i]);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (next & 1) queue_rays[next_half * EK_CHUNK + group_base[0] + place[0]] = slot;
  if (next >> 1) queue_shadow[group_base[1 + EK_SHADOW_PATHS] + place[1]] = slot;
#endif
}
