// SPDX-License-Identifier: Apache-2.0
// All stages from the camera to the end of the last path, for CPU devices.   From: chunks of the
// unit.   To: film slots. A work-item takes chunk after chunk and runs the stages over one until
// none of its paths goes on. The state is that of one chunk and stays in the cache; nothing is
// launched or read back in between. One work-item per core is enough. The host cannot know which of
// them is slow today, so they take paths from one counter, fewer at a time towards the end. Who
// takes which path changes no result.
#include "stages/paths/counter.h"
#include "stages/paths/ticks.h"
#include "stages/generate.h"
#include "stages/intersect.h"
#include "stages/miss.h"
#include "stages/shade.h"
#include "stages/shadow.h"

#if EK_CHUNKED
// Places in WorkerTally.ticks.
enum {
#define EK_PATH_STAGE(name) TICKS_##name,
#include "shared/stages.def"
  TICKS_COUNT
};

/// Splits the time of a work-item between the stages.
typedef struct {
  ulong begin, last;
  ulong stage_ticks[TICKS_COUNT];
} StageClock;

EK_FN StageClock stage_clock(void) {
  const ulong now = ticks_now();
  const StageClock clock = {.begin = now, .last = now};
  return clock;
}

/// Adds the ticks since the last call to the account of a stage.
EK_FN void stage_clock_lap(StageClock* clock, uint stage) {
  const ulong now = ticks_now();
  clock->stage_ticks[stage] += now - clock->last;
  clock->last = now;
}

/// The counts of a work-item: see WorkerTally.
typedef struct {
  uint scattered, shadow;
  uint depth_paths[EK_TALLY_DEPTHS], depth_shadow[EK_TALLY_DEPTHS];
  uint depth_chunks[EK_TALLY_DEPTHS], depth_vectors[EK_TALLY_DEPTHS];
} PathTally;

EK_FN void tally_add(PathTally* tally, uint depth, uint count, Survivors survivors) {
  const uint at = min(depth, (uint)EK_TALLY_DEPTHS) - 1u;
  tally->depth_paths[at] += count;
  tally->depth_shadow[at] += survivors.shadow_rays;
  tally->depth_chunks[at] += 1u;
  tally->depth_vectors[at] += (count + (EK_WIDTH - 1u)) / EK_WIDTH;
  tally->scattered += survivors.paths;
  tally->shadow += survivors.shadow_rays;
}

EK_FN void tally_store(global WorkerTally* out, PathTally tally, StageClock clock) {
  out->scattered = tally.scattered;
  out->shadow = tally.shadow;
  ticks_store(out->begin, clock.begin);
  ticks_store(out->end, clock.last);
  for (uint i = 0; i < TICKS_COUNT; ++i) ticks_store(out->ticks + 2 * i, clock.stage_ticks[i]);
  for (uint i = 0; i < EK_TALLY_DEPTHS; ++i) {
    out->depth_paths[i] = tally.depth_paths[i];
    out->depth_shadow[i] = tally.depth_shadow[i];
    out->depth_chunks[i] = tally.depth_chunks[i];
    out->depth_vectors[i] = tally.depth_vectors[i];
  }
}

EK_FN_ONCE void paths_run(StageContext stage, PathSource source, Geometry geometry, LightData light_data,
                          PathCounter counter, global WorkerTally* out) {
  StageClock clock = stage_clock();
  PathTally tally = {0};
  for (;;) {
    uint first;
    uint count = paths_take(counter, &first);
    if (count == 0) break;
    stage_generate(stage, source, first, count);
    stage_clock_lap(&clock, TICKS_generate);
    for (uint depth = 1; count != 0; ++depth) {
      stage_intersect(stage, geometry, count, depth);
      stage_clock_lap(&clock, TICKS_intersect);
      if (EK_HAS_environment | EK_HAS_environment_map) {
        stage_miss(stage, geometry.scene, light_data, count, depth);
        stage_clock_lap(&clock, TICKS_miss);
      }
      const Survivors survivors = stage_shade(stage, geometry.scene, light_data, count, depth);
      stage_clock_lap(&clock, TICKS_shade);
      if (EK_HAS_next_event) {
        stage_shadow(stage, geometry, survivors.shadow_rays, depth);
        stage_clock_lap(&clock, TICKS_shadow);
      }
      tally_add(&tally, depth, count, survivors);
      count = survivors.paths;
    }
  }
  tally_store(out, tally, clock);
}
#endif

// Its arguments are the buffers of all stages, bound by their names.
kernel void paths(constant Frame* frame, global const uint* pixels, global uint* path_state, global float* film_slots,
                  global const float* filter_table EK_CAMERA_ARGUMENTS, global const uint* accel_nodes, global const uint* accel_leaves,
                  EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS EK_LOG_ARGUMENT, global uint* next_path,
                  global WorkerTally* tallies) {
#if EK_CHUNKED
  const StageContext stage = {
      .frame = frame, .state = chunk_state(path_state), .film = {film_slots, frame->film_stride} EK_STAGE_LOG};
  const PathSource source = {pixels, filter_table EK_CAMERA_DATA};
  const LightData light_data = EK_LIGHT_DATA;
  const Geometry geometry = {accel_nodes, accel_leaves, EK_SCENE_DATA EK_NOT_OVER_TIME};
  const PathCounter counter = {next_path, frame->path_count, (uint)get_global_size(0)};
  paths_run(stage, source, geometry, light_data, counter, tallies + EK_CHUNK_INDEX);
#endif
}
