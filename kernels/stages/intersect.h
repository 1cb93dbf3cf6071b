// SPDX-License-Identifier: Apache-2.0
// Stage `intersect`.   From: paths of this depth.   To: the same paths, with their hits.
// Finds the closest hit of each path's ray. Reads the ray and the triangle that it leaves; writes
// hit_*. Nothing is shaded here, and only opacity's decisions are random.
#ifndef EK_STAGE_INTERSECT_H
#define EK_STAGE_INTERSECT_H
#include "shared/photon.h"
#include "stages/wavefront.h"
#include "traverse/traverse.h"

EK_FN_ONCE void stage_intersect(StageContext stage, Geometry geometry, uint count, uint depth) {
  cull_backs(&geometry, depth == 1 && !(EK_HAS_light_paths & (stage.frame->of_light_paths != EK_OF_CAMERA_PATHS)));
  Tracing tracing;
  PathWalk walk = path_walk(count);
  while (path_walk_next(&walk, stage.queue, EK_ROWS)) {
    tracing_clear(&tracing);
    for (uint row = 0; row < walk.lanes; row += EK_WIDTH) {
      const PathState path = path_load(stage.state, walk.slot + row);
      TracedRays rays = {.row = row,
                         .count = min(walk.lanes - row, (uint)EK_WIDTH),
                         .coherent = depth == 1,
                         .origin = path.origin,
                         .dir = path.dir,
                         .t_max = EK_INFINITY,
                         .ends = unknown_ends()};
      rays.ends.origin_prim = path.hit_triangle;
      if (EK_HAS_moving_surface) rays.time = path.time;
      if (EK_HAS_opacity) rays.key = opacity_key(path.key, path.index, depth, 0u);
      tracing_begin(stage.frame, geometry, &tracing, rays, 0);
    }
    tracing_finish(stage.frame, geometry, &tracing, 0);
    for (uint row = 0; row < walk.lanes; row += EK_WIDTH) {
      const HitLanes hit = closest_result(&tracing, row);
      const uint slot = walk.slot + row;
      state_set_vf(stage.state, FIELD_hit_t, slot, hit.t);
      state_set_vf(stage.state, FIELD_hit_u, slot, hit.u);
      state_set_vf(stage.state, FIELD_hit_v, slot, hit.v);
      state_set_vu(stage.state, FIELD_hit_triangle, slot, hit.triangle);
#if EK_HAS_instance
      state_set_vu(stage.state, FIELD_hit_instance, slot, hit.instance);
#endif
    }
  }
}

#endif
