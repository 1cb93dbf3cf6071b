// SPDX-License-Identifier: Apache-2.0
// Stage `splat`.   From: pending shadow rays of light paths.   To: the list of splats.
// Traces the shadow rays to the camera, and lists what arrives.
#ifndef EK_STAGE_SPLAT_H
#define EK_STAGE_SPLAT_H
#include "film/splat.h"
#include "stages/shadow.h"
#if EK_HAS_merging
#include "stages/light/photon.h"
#endif

#if EK_HAS_light_paths
EK_FN_ONCE void stage_splat(StageContext stage, Geometry geometry, RecordList list, uint count) {
#if EK_HAS_merging
  if (stage.frame->of_light_paths == EK_OF_PHOTONS) {
    photons_add(stage, list, count);
    return;
  }
#endif
  cull_backs(&geometry, 1);
  Tracing tracing;
  PathWalk walk = path_walk(count);
  while (path_walk_next(&walk, stage.queue, EK_ROWS)) {
    shadow_cast(stage, geometry, &tracing, walk.slot, walk.lanes, 0);
    for (uint row = 0; row < walk.lanes; row += EK_WIDTH) {
      const ShadowRay ray = shadow_load(stage.state, walk.slot + row);
      const vi arrives = (LANE_INDEX < (vu)(min(walk.lanes - row, (uint)EK_WIDTH))) & !any_result(&tracing, row);
      const vu group = EK_HAS_light_group ? ray.light_group << 24 : (vu)(0u);
      splat_add(list, arrives, ray.destination, ray.record_info | group, ray.radiance);
    }
  }
}
#endif

#endif
