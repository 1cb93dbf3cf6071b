// SPDX-License-Identifier: Apache-2.0
// Paths between stages: where their state lies, how a stage walks over them, and how those that go on are kept together.
//   EK_CHUNKED 1 (CPU devices): one work-item owns a chunk of EK_CHUNK slots in every stage. Paths lie in slots 0 .. count-1
//     of their chunk and move down in place when others end (shade.cl), so that stages read and write whole vectors.
//   EK_CHUNKED 0 (GPU devices): one chunk of EK_CHUNK slots for all; a path stays in its slot; queues hold the slots of the
//     paths that go on (compact.cl), and one work-item serves one entry.
// counts: four words per chunk: [depth & 1] paths at this depth, [(depth + 1) & 1] at the next, [2] pending shadow rays.
// The words of shadow rays have EK_LIGHT_SAMPLES slots for each path: on chunks they are packed from the first on; else ray k of
// the path in a slot is k * EK_CHUNK slots behind it.
#ifndef EK_WAVEFRONT_H
#define EK_WAVEFRONT_H
#include "lights/light_samples.h"
#include "lanes/math.h"
#include "lanes/simd.h"

// Words of state per path; a field that this program does not need has no place.
enum {
#define EK_FIELD(name, needed) FIELD_##name, FIELD_LAST_##name = FIELD_##name + (needed) - 1,
#define EK_SHADOW(name, needed) FIELD_##name, FIELD_LAST_##name = FIELD_##name + (needed) * EK_LIGHT_SAMPLES - 1,
#include "shared/path_state.def"
  FIELD_COUNT
};

// Slots between two fields: a power of two would put all fields of a path into one cache set.
#define EK_STRIDE (EK_CHUNK + EK_PAD)

// Layer `scattered`: bit i of EK_SCATTER_BOUNDS ends a bin behind light that was scattered i times; one more bin has the rest.
#ifndef EK_SCATTER_BOUNDS
#define EK_SCATTER_BOUNDS 0u
#define EK_SCATTER_BINS 1
#endif

// Layer `light_group`; EK_ENVIRONMENT_GROUP is that of the environment.
#ifndef EK_LIGHT_GROUPS
#define EK_LIGHT_GROUPS 1
#define EK_ENVIRONMENT_GROUP 0u
#endif

// Film slots of one path: R, G, B, then the layers that were asked for.
enum {
  FILM_r, FILM_g, FILM_b,
#define EK_AOV(name, channels) FILM_##name, FILM_LAST_##name = FILM_##name + (channels) * EK_HAS_##name - 1,
#include "shared/features.def"
  FILM_CHANNELS,
  // Planes behind them that are not summed: bits of numbers (film_layers.h).
  FILM_matte_object = FILM_CHANNELS,
  FILM_matte_material = FILM_matte_object + EK_HAS_matte_object,
  FILM_PLANES = FILM_matte_material + EK_HAS_matte_material
};

// Kernels know their work-item's place; stages are given what follows from it (EK_FN_ONCE).
#if EK_CHUNKED
#define EK_CHUNK_INDEX ((uint)get_global_id(0))
#define EK_ENTRY 0u
// Walks over the paths [0, count) of this chunk, EK_WIDTH at a time; the last lanes may lie beyond count.
#define EK_FOR_EACH(slot, count, queue) for (uint slot = 0; slot < (count); slot += EK_WIDTH)
#else
#define EK_CHUNK_INDEX 0u
#define EK_ENTRY ((uint)get_global_id(0))  // of the queue
// The path of this work-item's entry, the first of the queue that a stage is given; count: 1, or 0 beyond the queue's end.
#define EK_FOR_EACH(slot, count, queue) \
  for (uint left_ = (count), slot = left_ != 0u ? (queue)[0] : 0u; left_ != 0u; left_ = 0u)
#endif
// Walks over the slots that new paths are put into.
#define EK_FOR_EACH_NEW(slot, count) for (uint slot = 0; slot < (count); slot += EK_WIDTH)

// First word of this work-item's chunk.
EK_FN global uint* chunk_state(global uint* path_state) {
  return path_state + (size_t)EK_CHUNK_INDEX * FIELD_COUNT * EK_STRIDE;
}

// Of so many paths of the chunk, or of the queue, those that are this work-item's.
EK_FN uint own_count(uint count) { return EK_CHUNKED ? count : EK_ENTRY < count ? 1u : 0u; }
// This work-item's paths at a depth, and where they stand in the queue (not on chunks).
EK_FN uint depth_count(global const uint* counts, uint depth) {
  return own_count(counts[4 * EK_CHUNK_INDEX + (depth & 1)]);
}
EK_FN global const uint* depth_queue(global const uint* queue_rays, uint depth) {
  return queue_rays + (depth & 1) * EK_CHUNK + EK_ENTRY;
}

EK_FN vf state_f(global const uint* state, uint field, uint slot) {
  return load_f((global const float*)(state + field * EK_STRIDE + slot));
}
EK_FN vu state_u(global const uint* state, uint field, uint slot) { return load_u(state + field * EK_STRIDE + slot); }
EK_FN v3 state_3(global const uint* state, uint field, uint slot) {
  return V3(state_f(state, field, slot), state_f(state, field + 1, slot), state_f(state, field + 2, slot));
}
EK_FN void state_set_f(global uint* state, uint field, uint slot, vf x) {
  store_f((global float*)(state + field * EK_STRIDE + slot), x);
}
EK_FN void state_set_u(global uint* state, uint field, uint slot, vu x) { store_u(state + field * EK_STRIDE + slot, x); }
EK_FN void state_set_3(global uint* state, uint field, uint slot, v3 a) {
  state_set_f(state, field, slot, a.x);
  state_set_f(state, field + 1, slot, a.y);
  state_set_f(state, field + 2, slot, a.z);
}

// Three words of a shadow ray; each has room for EK_LIGHT_SAMPLES rays of every path.
EK_FN v3 shadow_state_3(global const uint* state, uint field, uint slot) {
  return V3(state_f(state, field, slot), state_f(state, field + EK_LIGHT_SAMPLES, slot),
            state_f(state, field + 2 * EK_LIGHT_SAMPLES, slot));
}

// Of one path, for stages that are scalar over paths.
EK_FN uint path_u(global const uint* state, uint field, uint slot) { return state[field * EK_STRIDE + slot]; }

// Adds to the film slots of each lane's path. Lane by lane: the processor has no scatter that is faster.
EK_FN void film_add(global float* film_slots, uint film_stride, uint channel, vi live, vu path, v3 value) {
  global float* red = film_slots + (size_t)channel * film_stride;
  global float* green = red + film_stride;
  global float* blue = green + film_stride;
#if EK_WIDTH == 1
  if (!live) return;
  red[path] += value.x;
  green[path] += value.y;
  blue[path] += value.z;
#else
  uint paths[EK_WIDTH];
  float r[EK_WIDTH], g[EK_WIDTH], b[EK_WIDTH];
  *(vu_unaligned*)paths = path;
  *(vf_unaligned*)r = value.x;
  *(vf_unaligned*)g = value.y;
  *(vf_unaligned*)b = value.z;
  for (uint bits = mask_bits(live); bits != 0; bits &= bits - 1) {
    const uint lane = lowest_bit(bits), at = paths[lane];
    red[at] += r[lane];
    green[at] += g[lane];
    blue[at] += b[lane];
  }
#endif
}

// Adds light that met so many surfaces between its source and the camera.
// crossed  of them do not show, and scattered nothing;  group  of the source: index of its light group
EK_FN void film_add_light(global float* film_slots, uint film_stride, vi live, vu path, uint scattered, vu crossed, vu group,
                          v3 radiance) {
  film_add(film_slots, film_stride, FILM_r, live, path, radiance);
  if (EK_HAS_scattered & EK_HAS_nested_media) {
    vu bin = (vu)(0u);
    for (uint bits = EK_SCATTER_BOUNDS; bits != 0u; bits &= bits - 1u) {
      const uint bound = lowest_bit(bits);
      bin = bin + (((vu)(scattered) - crossed > bound) ? (vu)(1u) : (vu)(0u));
    }
    film_add(film_slots, film_stride, FILM_scattered, live, path + bin * (3u * film_stride), radiance);
  } else if (EK_HAS_scattered) {
    const uint bin = popcount(EK_SCATTER_BOUNDS & ((1u << min(scattered, 31u)) - 1u));
    film_add(film_slots, film_stride, FILM_scattered + 3 * bin, live, path, radiance);
  }
  if (EK_HAS_light_group)
    film_add(film_slots, film_stride, FILM_light_group, live, path + group * (3u * film_stride), radiance);
}

#endif
