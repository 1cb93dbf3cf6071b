// SPDX-License-Identifier: Apache-2.0
// All stages of light paths, for CPU devices.
// From: chunks of the unit's light paths.   To: the list of splats.
// Works as paths.cl does.
#include "stages/intersect.h"
#include "stages/light/generate.h"
#include "stages/light/shade.h"
#include "stages/paths/counter.h"
#include "stages/light/splat.h"

#if EK_CHUNKED & EK_HAS_light_paths
EK_FN_ONCE void light_paths_run(StageContext stage, Geometry geometry, LightData light_data, PathSource source,
                                PathCounter counter, RecordList list) {
  uint path_rays = 0, shadow_rays = 0;
  for (;;) {
    uint first;
    uint count = paths_take(counter, &first);
    if (count == 0) break;
    stage_light_generate(stage, geometry.scene, light_data, source, first, count);
    for (uint depth = 1; count != 0; ++depth) {
      path_rays += count;
      stage_intersect(stage, geometry, count, depth);
      const Survivors survivors = stage_light_shade(stage, geometry.scene, light_data, source.filter_table, count, depth);
      stage_splat(stage, geometry, list, survivors.shadow_rays);
      shadow_rays += survivors.shadow_rays;
      count = survivors.paths;
    }
  }
  atomic_add(list.counts + SPLATS_path_rays, path_rays);
  atomic_add(list.counts + SPLATS_shadow_rays, shadow_rays);
}
#endif

kernel void light_paths(constant Frame* frame, global const uint* pixels, global uint* path_state, global const uint* accel_nodes,
                        global const uint* accel_leaves, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS, global const float* filter_table,
                        global uint* next_path, global uint* splats, global uint* splat_counts) {
#if EK_CHUNKED & EK_HAS_light_paths
  const StageContext stage = {.frame = frame, .state = chunk_state(path_state)};
  const LightData light_data = EK_LIGHT_DATA;
  const Geometry geometry = {accel_nodes, accel_leaves, EK_SCENE_DATA EK_NOT_OVER_TIME};
  const PathCounter counter = {next_path, frame->path_count, (uint)get_global_size(0)};
  const RecordList list = {splats, splat_counts, frame->splat_capacity};
  const PathSource source = {.pixels = pixels, .filter_table = filter_table};
  light_paths_run(stage, geometry, light_data, source, counter, list);
#endif
}
