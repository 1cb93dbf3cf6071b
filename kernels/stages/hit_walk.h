// SPDX-License-Identifier: Apache-2.0
// The order in which a chunk's hits are shaded. A vector of paths executes the code of every kind
// of surface that its lanes have hit. So on chunks, where the scene has surfaces of several shading
// classes (SHADING_*, records.h), paths wait until EK_WIDTH of a class have come together, and
// paths that hit nothing are left out. This grouping changes no result, because each path is shaded
// independently.
#ifndef EK_HIT_WALK_H
#define EK_HIT_WALK_H
#include "lanes/compact.h"
#include "stages/wavefront.h"
#include "surface/scene_data.h"

// Bit k: the scene has surfaces of class k.
#define EK_CLASSES_HERE (EK_HAS_flat_lambert_hits | EK_HAS_opaque_hits << 1 | EK_HAS_transmissive_hits << 2)
#define EK_SPLITS (EK_CHUNKED && EK_WIDTH > 1 && (EK_CLASSES_HERE & (EK_CLASSES_HERE - 1)) != 0)

/// A walk over this work-item's hits, as PathWalk is one over paths.
typedef struct {
  uint slot, lanes;                 // of this step
  PathWalk paths;                   // that have not been looked at
  uint waiting[SHADING_CLASS_COUNT];   // how many paths of each class wait (EK_SPLITS)
} HitWalk;

EK_FN HitWalk hit_walk(uint count) {
  HitWalk walk;
  walk.paths = path_walk(count);
  for (uint k = 0; k < SHADING_CLASS_COUNT; ++k) walk.waiting[k] = 0;
  return walk;
}

/// The shading class, one of SHADING_*, of triangles of these flags.
EK_FN vu shading_class_of(vu flags) { return (flags >> EK_TRIANGLE_CLASS_SHIFT) & 3u; }

/// Paths of class k wait here: behind the chunk, and behind what vectors that are written at its
/// end may touch, there is room for two vectors of each class.
EK_FN uint waiting_slot(uint k) { return EK_CHUNK + 16u + k * (2u * EK_WIDTH); }

#if EK_SPLITS
#if EK_PAD < 16 + 2 * EK_WIDTH * SHADING_CLASS_COUNT
#error "EK_PAD has no room for the paths that wait"
#endif

/// Moves the paths of this step of the walk to where those of their class wait, which are fewer
/// than EK_WIDTH in each class.
EK_FN void hits_wait(HitWalk* walk, SceneData scene, global uint* state) {
  const uint slot = walk->paths.slot;
  const vu hit = state_vu(state, FIELD_hit_triangle, slot);
  const vi some = (LANE_INDEX < (vu)(walk->paths.lanes)) & (hit != EK_NO_HIT);
  const vu classes = shading_class_of(load_word_u(Triangle, scene.triangles, some ? hit : (vu)(0u), flags));
  for (uint k = 0; k < SHADING_CLASS_COUNT; ++k) {
    if ((EK_CLASSES_HERE >> k & 1) == 0) continue;
    const Packing own = packing(some & (classes == k));
    const uint to = waiting_slot(k) + walk->waiting[k];
#pragma unroll
    for (uint word = 0; word < PATH_WORDS; ++word)
      state_pack_vu(state, word, to, own, state_vu(state, word, slot));
    walk->waiting[k] += own.count;
  }
}

/// Takes a vector of paths of a class that has enough of them, or any at all when no more will
/// come. returns 0 if none has
EK_FN int hits_take(HitWalk* walk, int no_more_come) {
  for (uint k = 0; k < SHADING_CLASS_COUNT; ++k) {
    const uint waiting = walk->waiting[k];
    if (waiting < EK_WIDTH && !(no_more_come && waiting != 0)) continue;
    walk->lanes = min(waiting, (uint)EK_WIDTH);
    walk->waiting[k] = waiting - walk->lanes;
    walk->slot = waiting_slot(k) + walk->waiting[k];
    return 1;
  }
  return 0;
}
#endif

/// Fetches the records of the next hits while these are shaded, for meshes larger than a core's
/// caches.
EK_FN void hits_fetch_ahead(const HitWalk* walk, SceneData scene, global const uint* state) {
#if EK_CHUNKED && EK_MEDIUM_TREE && EK_CPU
  const uint count = min(walk->paths.count, walk->paths.next + EK_WIDTH);
#if EK_HAS_moving_surface
  global const uint* first_poses = scene.motion + scene.motion[1];
  for (uint slot = count; slot < min(walk->paths.count, count + EK_WIDTH); ++slot) {
    const uint hit = state[FIELD_hit_triangle * EK_STRIDE + slot];
    if (hit != EK_NO_HIT) EK_PREFETCH(first_poses + hit);
  }
#endif
  for (uint slot = walk->paths.next; slot < count; ++slot) {
    const uint hit = state[FIELD_hit_triangle * EK_STRIDE + slot];
    if (hit == EK_NO_HIT) continue;
#if EK_HAS_moving_surface
    const uint first = first_poses[hit];
    if (first != 0u) {
      const float time = as_float(state[FIELD_time * EK_STRIDE + slot]);
      const uint before = first - 1u + min((uint)(time * (float)scene.motion[0]), scene.motion[0] - 1u);
      EK_PREFETCH(scene.pose_triangles + before);
      EK_PREFETCH(scene.pose_triangles + before + 1u);
      if (EK_HAS_vertex_normal) {
        EK_PREFETCH(scene.pose_normals + before);
        EK_PREFETCH(scene.pose_normals + before + 1u);
      }
      if (!EK_SPLITS) continue;
    }
#endif
    EK_PREFETCH(scene.triangles + hit);
    if (EK_HAS_vertex_normal) EK_PREFETCH(scene.triangle_normals + hit);
  }
#endif
}

/// Goes to the next hits to shade, and maybe paths that hit nothing. returns 0 when there are no
/// more
EK_FN int hit_walk_next(HitWalk* walk, SceneData scene, global uint* state, global const uint* queue) {
#if EK_SPLITS
  for (;;) {
    const int no_more_come = walk->paths.next >= walk->paths.count;
    if (hits_take(walk, no_more_come)) return 1;
    if (no_more_come) return 0;
    path_walk_next(&walk->paths, queue, EK_WIDTH);
    hits_fetch_ahead(walk, scene, state);
    hits_wait(walk, scene, state);
  }
#else
  if (!path_walk_next(&walk->paths, queue, EK_WIDTH)) return 0;
  hits_fetch_ahead(walk, scene, state);
  walk->slot = walk->paths.slot;
  walk->lanes = walk->paths.lanes;
  return 1;
#endif
}

#endif
