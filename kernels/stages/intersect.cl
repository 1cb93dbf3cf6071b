// SPDX-License-Identifier: Apache-2.0
// Stage `intersect`.   From: paths of this depth.   To: the same paths, with their hits.
// Finds the closest hit of each path's ray. Reads origin and dir, writes hit_*; no shading, no randomness.
#include "traverse.h"
#include "wavefront.h"

kernel void intersect(constant Frame* frame, global uint* path_state, global const uint* counts,
                      global const uint* queue_rays, global const uint* accel_nodes, global const uint* accel_leaves,
                      global const Triangle* triangles, uint depth) {
  global uint* state = chunk_state(path_state);
  const Geometry geometry = {accel_nodes, accel_leaves, triangles};
  const uint count = counts[4 * EK_CHUNK_INDEX + (depth & 1)];
  EK_FOR_EACH(slot, count, queue_rays + (depth & 1) * EK_CHUNK) {
    const uint lanes = EK_CHUNKED ? min(count - slot, (uint)EK_WIDTH) : 1u;
    const HitLanes hit = closest_hit(frame, geometry, state_3(state, FIELD_origin_x, slot),
                                     state_3(state, FIELD_dir_x, slot), lanes, depth == 1);
    state_set_f(state, FIELD_hit_t, slot, hit.t);
    state_set_f(state, FIELD_hit_u, slot, hit.u);
    state_set_f(state, FIELD_hit_v, slot, hit.v);
    state_set_u(state, FIELD_hit_triangle, slot, hit.triangle);
  }
}
