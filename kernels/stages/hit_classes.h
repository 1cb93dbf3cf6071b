// SPDX-License-Identifier: Apache-2.0
// Hits in the order in which they are shaded. A vector of paths takes the code of all surfaces that its lanes have hit. So on chunks,
// where the scene has surfaces of several classes (records.h: EK_CLASS_*), paths wait until there are EK_WIDTH of a class, and paths
// that hit nothing are left out. Which paths go together shows in no bit.
#ifndef EK_HIT_CLASSES_H
#define EK_HIT_CLASSES_H
#include "surface/scene_data.h"
#include "lanes/simd.h"
#include "stages/wavefront.h"

#define EK_CLASSES_HERE (EK_HAS_plain_hits | EK_HAS_opaque_hits << 1 | EK_HAS_clear_hits << 2)  // bit k: class k
#define EK_SPLITS (EK_CHUNKED && EK_WIDTH > 1 && (EK_CLASSES_HERE & (EK_CLASSES_HERE - 1)) != 0)

// A walk over the hits of a chunk.
typedef struct {
  uint slot, count;  // of the chunk: the next path, and how many there are
#if EK_SPLITS
  uint waiting[EK_CLASS_COUNT];
#endif
} HitWalk;

EK_FN HitWalk hit_walk(uint count) {
  HitWalk walk;
  walk.slot = 0;
  walk.count = count;
#if EK_SPLITS
  for (uint k = 0; k < EK_CLASS_COUNT; ++k) walk.waiting[k] = 0;
#endif
  return walk;
}

// Which of EK_CLASS_* the triangles of these flags are of.
EK_FN vu class_of(vu flags) { return (flags >> EK_TRIANGLE_CLASS_SHIFT) & 3u; }
EK_FN vi is_plain(vu flags) { return class_of(flags) == EK_CLASS_PLAIN; }

#if EK_SPLITS
#if EK_PAD < 16 + 2 * EK_WIDTH * EK_CLASS_COUNT
#error "EK_PAD has no room for the paths that wait"
#endif
// Where paths of class k wait: behind the chunk and what vectors that are written there may touch, room for two vectors each.
EK_FN uint waiting_slot(uint k) { return EK_CHUNK + 16u + k * (2u * EK_WIDTH); }

// Moves EK_WIDTH paths from `slot` to where those of their class wait, which are fewer than EK_WIDTH each.
EK_FN void hits_wait(HitWalk* walk, SceneData scene, global uint* state) {
  const uint slot = walk->slot;
  const vu hit = state_u(state, FIELD_hit_triangle, slot);
  const vi some = ((vu)(slot) + LANE_INDEX < (vu)(walk->count)) & (hit != EK_NO_HIT);
  const vu which = class_of(load_word_u(Triangle, scene.triangles, some ? hit : (vu)(0u), flags));
#if EK_HAS_COMPRESS
  for (uint k = 0; k < EK_CLASS_COUNT; ++k) {
    if ((EK_CLASSES_HERE >> k & 1) == 0) continue;
    const Packing own = packing(some & (which == k));
    const uint to = waiting_slot(k) + walk->waiting[k];
#define EK_FIELD(name, needed) \
  if (needed) state_set_u(state, FIELD_##name, to, packed(own, state_u(state, FIELD_##name, slot)));
#include "shared/path_state.def"
    walk->waiting[k] += own.count;
  }
#else
  uint of_lane[EK_WIDTH];
  *(vu_unaligned*)of_lane = which;
  for (uint bits = mask_bits(some); bits != 0; bits &= bits - 1u) {
    const uint lane = lowest_bit(bits), k = of_lane[lane], to = waiting_slot(k) + walk->waiting[k];
#define EK_FIELD(name, needed) \
  if (needed) state[FIELD_##name * EK_STRIDE + to] = state[FIELD_##name * EK_STRIDE + slot + lane];
#include "shared/path_state.def"
    ++walk->waiting[k];
  }
#endif
  walk->slot += EK_WIDTH;
}
#endif

// In meshes larger than a core's caches the next hits' records are fetched while these are shaded.
EK_FN void hits_fetch_ahead(const HitWalk* walk, SceneData scene, global const uint* state) {
#if EK_CHUNKED && EK_MEDIUM_TREE && EK_BUILTIN(__builtin_prefetch)
  global const uint* hits = state + FIELD_hit_triangle * EK_STRIDE + walk->slot + EK_WIDTH;
  const uint count = min(walk->count, walk->slot + 2u * EK_WIDTH);
  for (uint i = 0; walk->slot + EK_WIDTH + i < count; ++i) {
    if (hits[i] == EK_NO_HIT) continue;
    __builtin_prefetch(scene.triangles + hits[i]);
    if (EK_HAS_vertex_normal) __builtin_prefetch(scene.triangle_normals + hits[i]);
  }
#endif
}

// The next hits to shade: of *lanes paths, at most EK_WIDTH, from slot *from on. returns 0 when there are no more
EK_FN int next_hits(HitWalk* walk, SceneData scene, global uint* state, uint* from, uint* lanes) {
#if EK_SPLITS
  for (;;) {
    const int ends = walk->slot >= walk->count;
    for (uint k = 0; k < EK_CLASS_COUNT; ++k) {
      const uint waiting = walk->waiting[k];
      if (waiting >= EK_WIDTH || (ends && waiting != 0)) {
        *lanes = min(waiting, (uint)EK_WIDTH);
        walk->waiting[k] = waiting - *lanes;
        *from = waiting_slot(k) + walk->waiting[k];
        return 1;
      }
    }
    if (ends) return 0;
    hits_fetch_ahead(walk, scene, state);
    hits_wait(walk, scene, state);
  }
#else
  if (walk->slot >= walk->count) return 0;
  hits_fetch_ahead(walk, scene, state);
  *from = walk->slot;
  *lanes = min(walk->count - walk->slot, (uint)EK_WIDTH);
  walk->slot += EK_WIDTH;
  return 1;
#endif
}

// Walks over the paths [0, count) of this chunk that hit something, and maybe others: `lanes` at a time, which stand in `slot` and those
// behind it; or as EK_FOR_EACH over the path of this work-item. slot, lanes: variables of the caller's.
#if EK_CHUNKED
#define EK_FOR_EACH_HIT(slot, lanes, scene, state, count, queue) \
  for (HitWalk walk_ = hit_walk(count); next_hits(&walk_, scene, state, &(slot), &(lanes));)
#else
#define EK_FOR_EACH_HIT(slot, lanes, scene, state, count, queue) \
  for (uint left_ = (count); left_ != 0u && ((slot) = (queue)[0], (lanes) = 1u); left_ = 0u)
#endif

#endif
