// SPDX-License-Identifier: Apache-2.0
// Stage `shadow`.   From: pending shadow rays of this depth.
// Adds what a shadow ray carries to its path's film slots, if nothing is in the way. All rays of a
// path belong to one work-item, which adds what they bring in their order; so nobody else adds to
// those slots meanwhile, and a sum has the same bits on all devices.
#ifndef EK_STAGE_SHADOW_H
#define EK_STAGE_SHADOW_H
#include "stages/wavefront.h"
#include "traverse/traverse.h"

/// Traces the shadow rays in `slot` and those behind it; any_result tells which of them meet
/// something.
/// count  rays, at most EK_ROWS; coherent: they start together
EK_FN void shadow_cast(StageContext stage, Geometry geometry, Tracing* tracing, uint slot, uint count, int coherent) {
  tracing_clear(tracing);
  for (uint row = 0; row < count; row += EK_WIDTH) {
    const ShadowRay ray = shadow_load(stage.state, slot + row);
    TracedRays rays = {.row = row,
                       .count = min(count - row, (uint)EK_WIDTH),
                       .coherent = coherent,
                       .origin = ray.origin,
                       .dir = ray.dir,
                       .t_max = ray.t_max,
                       .ends = unknown_ends()};
    if (!EK_HAS_instance) rays.ends.origin_prim = ray.origin_prim;
    if (EK_HAS_area & !EK_HAS_instance) rays.ends.target_prim = ray.target_prim;
    if (EK_HAS_moving_surface) rays.time = ray.time;
    if (EK_HAS_opacity) {
      rays.key.key = ray.opacity_key;
      rays.key.index = ray.opacity_index;
    }
    tracing_begin(stage.frame, geometry, tracing, rays, 1);
  }
  tracing_finish(stage.frame, geometry, tracing, 1);
}

/// Traces the shadow rays in a slot and those behind it, and adds what they carry to the film where
/// nothing is in the way.
EK_FN void shadow_trace(StageContext stage, Geometry geometry, Tracing* tracing, uint slot, uint count, uint depth) {
  shadow_cast(stage, geometry, tracing, slot, count, depth == 1);
  for (uint row = 0; row < count; row += EK_WIDTH) {
    const ShadowRay ray = shadow_load(stage.state, slot + row);
    const vi in_use = LANE_INDEX < (vu)(min(count - row, (uint)EK_WIDTH));
    const Contribution light = {
        .live = in_use & !any_result(tracing, row),
        .path = ray.destination,
        .uncounted = (EK_USES_NULL_INTERFACES & EK_HAS_bounce_bins) ? ray.null_interface_count : (vu)(0u),
        .group = EK_HAS_light_group ? ray.light_group : (vu)(0u),
        .radiance = ray.radiance};
    film_add_light(stage.film, depth, light);
#if EK_HAS_path_log
    log_set_f(stage.log, depth, LOG_sampled, light.live, ray.destination, ray.logged);
#endif
  }
}

EK_FN_ONCE void stage_shadow(StageContext stage, Geometry geometry, uint count, uint depth) {
  Tracing tracing;
  PathWalk walk = path_walk(count);
  while (path_walk_next(&walk, stage.queue, EK_ROWS)) {
    // Bit k: trace the rays k * EK_CHUNK slots behind. On chunks all pending rays lie in a row.
    uint pending = 1u;
    if (EK_SHADOW_PATHS) pending = stage.state[FIELD_next * EK_STRIDE + walk.slot] >> 1;
    for (; pending != 0u; pending &= pending - 1u)
      shadow_trace(stage, geometry, &tracing, walk.slot + lowest_bit(pending) * EK_CHUNK, walk.lanes, depth);
  }
}

#endif
