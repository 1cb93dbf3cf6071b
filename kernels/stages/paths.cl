// SPDX-License-Identifier: Apache-2.0
// All stages from the camera to the end of the last path, for CPU devices.   From: chunks of the unit.   To: film slots.
// A work-item takes chunk after chunk and runs the stages over one until none of its paths goes on. Their state is that of one
// chunk and stays in the cache; nothing is launched or read back in between. One work-item per core is enough, and the host
// cannot know which of them is slow today, so they take paths from one counter, fewer at a time towards the end. Who takes what
// does not show in the picture.
#include "stages/generate.h"
#include "stages/intersect.h"
#include "stages/miss.h"
#include "stages/shade.h"
#include "stages/shadow.h"
#include "probe/ticks.h"

#define EK_LEAST_PORTION 256  // paths, a multiple of every width: fewer leave lanes and rows of rays empty

// Places in WorkerTally.ticks.
enum {
#define EK_PATH_STAGE(name) TICKS_##name,
#include "shared/stages.def"
  TICKS_COUNT
};

// Runs a stage and adds the ticks since the last one to its account.
#define EK_TIMED(name, call)               \
  do {                                     \
    call;                                  \
    const ulong now_ = ticks_now();        \
    ticks[TICKS_##name] += now_ - time;    \
    time = now_;                           \
  } while (0)

#if EK_CHUNKED
// Reserves the next paths of the unit for this work-item. returns how many; first: index of the first
EK_FN uint paths_take(global uint* next_path, uint path_count, uint workers, uint* first) {
  // The look ahead only sizes the portion; what others take in between does no harm.
  const uint seen = *(volatile global uint*)next_path;
  const uint left = seen < path_count ? path_count - seen : 0u;
  const uint share = left / (4u * workers) / EK_LEAST_PORTION * EK_LEAST_PORTION;
  const uint portion = clamp(share, min((uint)EK_LEAST_PORTION, (uint)EK_CHUNK), (uint)EK_CHUNK);
  *first = atomic_add(next_path, portion);
  return *first < path_count ? min(path_count - *first, portion) : 0u;
}

// workers  work-items of the launch
EK_FN_ONCE void paths_run(constant Frame* frame, global const uint* pixels, global uint* state, global float* film_slots,
                          global const float* filter_table, Geometry geometry, SceneData scene, LightData light_data,
                          global uint* next_path, global WorkerTally* tally, uint workers) {
  const uint path_count = frame->path_count;
  ulong time = ticks_now(), ticks[TICKS_COUNT] = {0};
  const ulong begin = time;
  uint scattered = 0, shadow_rays = 0;
  uint depth_paths[EK_TALLY_DEPTHS] = {0}, depth_shadow[EK_TALLY_DEPTHS] = {0}, depth_chunks[EK_TALLY_DEPTHS] = {0},
       depth_vectors[EK_TALLY_DEPTHS] = {0};
  for (;;) {
    uint first;
    uint count = paths_take(next_path, path_count, workers, &first);
    if (count == 0) break;
    EK_TIMED(generate, stage_generate(frame, pixels, state, film_slots, filter_table, first, count));
    for (uint depth = 1; count != 0; ++depth) {
      EK_TIMED(intersect, stage_intersect(frame, geometry, state, 0, count, depth));
      if (EK_HAS_environment | EK_HAS_environment_map)
        EK_TIMED(miss, stage_miss(frame, scene, light_data.environment_texels, state, film_slots, 0, count, depth));
      Survivors survivors;
      EK_TIMED(shade, survivors = stage_shade(frame, scene, light_data, state, film_slots, 0, count, depth));
      if (EK_HAS_next_event)
        EK_TIMED(shadow, stage_shadow(frame, geometry, state, film_slots, 0, survivors.shadow, depth));
      const uint at = min(depth, (uint)EK_TALLY_DEPTHS) - 1u;
      depth_paths[at] += count;
      depth_shadow[at] += survivors.shadow;
      depth_chunks[at] += 1u;
      depth_vectors[at] += (count + (EK_WIDTH - 1u)) / EK_WIDTH;
      count = survivors.next;
      scattered += survivors.next;
      shadow_rays += survivors.shadow;
    }
  }
  tally->scattered = scattered;
  tally->shadow = shadow_rays;
  ticks_store(tally->begin, begin);
  ticks_store(tally->end, time);
  for (uint i = 0; i < TICKS_COUNT; ++i) ticks_store(tally->ticks + 2 * i, ticks[i]);
  for (uint i = 0; i < EK_TALLY_DEPTHS; ++i) {
    tally->depth_paths[i] = depth_paths[i];
    tally->depth_shadow[i] = depth_shadow[i];
    tally->depth_chunks[i] = depth_chunks[i];
    tally->depth_vectors[i] = depth_vectors[i];
  }
}
#endif

// next_path  0 before the launch
kernel void paths(constant Frame* frame, global const uint* pixels, global uint* path_state, global float* film_slots,
                  global const float* filter_table, global const uint* accel_nodes, global const uint* accel_leaves,
                  EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS, global uint* next_path, global WorkerTally* tallies) {
#if EK_CHUNKED
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  const Geometry geometry = {accel_nodes, accel_leaves, EK_SCENE_DATA};
  paths_run(frame, pixels, chunk_state(path_state), film_slots, filter_table, geometry, scene, light_data, next_path,
            tallies + EK_CHUNK_INDEX, (uint)get_global_size(0));
#endif
}
