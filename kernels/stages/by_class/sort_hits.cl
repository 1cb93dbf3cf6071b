// SPDX-License-Identifier: Apache-2.0
// Stage `sort_hits`, on GPU devices, in scenes with surfaces of several shading classes.
// From: paths of this depth, with their hits.
// To: the queue of each class in queue_hits (hit_queues.h).
// Work-groups count their hits in local memory and reserve places with one atomic for each class.
// The order in the queues is not deterministic, and nothing depends on it. Paths that hit nothing
// are in none of them.
#include "stages/by_class/hit_queues.h"

kernel void sort_hits(global uint* path_state, global uint* counts, global const uint* queue_rays, global uint* queue_hits,
                      global const Triangle* triangles, uint depth) {
#if !EK_CHUNKED
  local uint group_count[SHADING_CLASS_COUNT], group_base[SHADING_CLASS_COUNT];
  const uint entry = (uint)get_global_id(0), lane = (uint)get_local_id(0);
  const uint count = counts[depth & 1];
  if (lane < SHADING_CLASS_COUNT) group_count[lane] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint slot = entry < count ? queue_rays[(depth & 1) * EK_CHUNK + entry] : 0u;
  const uint hit = entry < count ? path_state[FIELD_hit_triangle * EK_STRIDE + slot] : EK_NO_HIT;
  const uint k = hit == EK_NO_HIT ? SHADING_CLASS_COUNT : shading_class_of(triangles[hit].flags);
  const uint place = hit == EK_NO_HIT ? 0u : atomic_inc(&group_count[k]);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane < SHADING_CLASS_COUNT) group_base[lane] = atomic_add(hit_counts(counts, depth) + lane, group_count[lane]);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (hit != EK_NO_HIT)
    queue_hits[hit_queue_begin(k) + group_base[k] + place] = slot;
  else if (entry < count)
    path_state[FIELD_next * EK_STRIDE + slot] = 0u;  // no stage that shades will say that the path ends
  clear_counts(counts, depth);
#endif
}
