// SPDX-License-Identifier: Apache-2.0
// The wavefront: which paths a work-item of a stage serves, and how it walks over them.
// - EK_CHUNKED 1 (CPU devices): a work-item owns a chunk of EK_CHUNK slots in every stage. Paths
//   lie in slots 0 .. count - 1 of their chunk and move down in place when others end (stage
//   shade), so stages read and write whole vectors.
// - EK_CHUNKED 0 (GPU devices): all paths share one chunk of EK_CHUNK slots. A path stays in its
//   slot, queues hold the slots of the paths that go on (compact.cl), and a work-item serves one
//   entry of a queue.
// counts holds four words per chunk: [depth & 1] paths at this depth, [(depth + 1) & 1] paths at
// the next, [2] pending shadow rays, [3] with EK_SHADOW_PATHS the paths that have some. Without
// chunks the words of shared/queue_counts.h follow.
#ifndef EK_WAVEFRONT_H
#define EK_WAVEFRONT_H
#include "film/slots.h"
#include "guide/guide.h"
#include "guide/path_log.h"
#include "stages/path_state.h"

/// The part of the wavefront that every stage gets.
typedef struct {
  constant Frame* frame;
  global uint* state;        // of this work-item's chunk (chunk_state)
  global const uint* queue;  // from this work-item's entry on (depth_queue); unused on chunks
  FilmSlots film;
#if EK_HAS_path_log
  PathLog log;
#endif
} StageContext;

#if EK_HAS_path_log
#define EK_STAGE_LOG , .log = EK_LOG
#else
#define EK_STAGE_LOG
#endif

// Only kernels ask for their work-item's place and hand it to stages, for the reason that
// EK_FN_ONCE gives (lanes.h).
#if EK_CHUNKED
#define EK_CHUNK_INDEX ((uint)get_global_id(0))
#define EK_ENTRY 0u
#else
#define EK_CHUNK_INDEX 0u
#define EK_ENTRY ((uint)get_global_id(0))  // of the queue
#endif

// 1 where a path may have several pending shadow rays and stays in its slot: then queue_shadow
// holds its slot once, and one work-item traces all its rays.
#define EK_SHADOW_PATHS (!EK_CHUNKED & (EK_LIGHT_SAMPLES > 1))

/// First word of this work-item's chunk.
EK_FN global uint* chunk_state(global uint* path_state) {
  return path_state + (size_t)EK_CHUNK_INDEX * STATE_WORDS * EK_STRIDE;
}

/// The number of this work-item's paths: `count` of a chunk, or at most one entry of the queue.
EK_FN uint own_count(uint count) { return EK_CHUNKED ? count : EK_ENTRY < count ? 1u : 0u; }

/// The number of this work-item's paths of a depth; they stand in the queue of that depth.
EK_FN uint depth_count(global const uint* counts, uint depth) {
  return own_count(counts[4 * EK_CHUNK_INDEX + (depth & 1)]);
}
/// The number of shadow rays of this work-item's chunk; without chunks 1 if it has an entry of
/// queue_shadow, else 0.
EK_FN uint shadow_count(global const uint* counts) {
  return own_count(counts[4 * EK_CHUNK_INDEX + (EK_SHADOW_PATHS ? 3 : 2)]);
}
EK_FN global const uint* depth_queue(global const uint* queue_rays, uint depth) {
  return queue_rays + (depth & 1) * EK_CHUNK + EK_ENTRY;
}

#if !EK_CHUNKED
#include "shared/queue_counts.h"
EK_FN global uint* counts_of_depth(global uint* counts, uint depth) {
  return counts + 4 + EK_DEPTH_WORDS * (depth & (EK_COUNT_DEPTHS - 1u));
}
// 1 where the scene has surfaces of several shading classes, each of which has a queue
// (hit_queues.h).
#define EK_HIT_QUEUES (EK_HAS_flat_lambert_hits + EK_HAS_opaque_hits + EK_HAS_transmissive_hits > 1)
/// Clears the numbers of hits that stage sort_hits adds to.
EK_FN void clear_hit_counts(global uint* counts, uint depth) {
  if (EK_HIT_QUEUES) *(global uint4*)(counts_of_depth(counts, depth) + EK_DEPTH_HITS) = (uint4)(0u);
}
#endif

/// Puts the paths of a new unit into the queue of depth 1. count: of this work-item's chunk
EK_FN void begin_queue(global uint* counts, global uint* queue_rays, uint count) {
#if EK_CHUNKED
  counts[4 * EK_CHUNK_INDEX + 1] = count;
#else
  if (EK_ENTRY == 0) {
    counts[1] = count;
    clear_hit_counts(counts, 1);
  }
  if (EK_ENTRY < count) queue_rays[EK_CHUNK + EK_ENTRY] = EK_ENTRY;  // the half of odd depths
#endif
}

/// The counts of a chunk after shading; without chunks stage compact counts.
typedef struct {
  uint paths;        // of the next depth
  uint shadow_rays;  // pending
} Survivors;

/// Stores the counts of a chunk after shading. Without chunks stage compact counts.
EK_FN void store_survivors(global uint* counts, uint depth, Survivors survivors) {
#if EK_CHUNKED
  counts[4 * EK_CHUNK_INDEX + ((depth + 1) & 1)] = survivors.paths;
  counts[4 * EK_CHUNK_INDEX + 2] = survivors.shadow_rays;
#endif
}

/// Clears the counts that stages of this depth and the next add to, once they are kept for the
/// host.
EK_FN void clear_counts(global uint* counts, uint depth) {
#if !EK_CHUNKED
  if (get_global_id(0) == 0) {
    clear_hit_counts(counts, depth + 1u);
    counts_of_depth(counts, depth)[0] = counts[depth & 1];
    counts_of_depth(counts, depth - 1u)[1] = counts[2];
    counts[(depth + 1) & 1] = counts[2] = 0;
    if (EK_SHADOW_PATHS) counts[3] = 0;
  }
#endif
}

/// A walk over this work-item's paths:  PathWalk walk = path_walk(count);  while
/// (path_walk_next(&walk, queue, EK_WIDTH)) ...
typedef struct {
  uint slot;   // of the first path of this step
  uint lanes;  // paths of this step
  uint next, count;
} PathWalk;

/// count  as depth_count() returns it
EK_FN PathWalk path_walk(uint count) {
  const PathWalk walk = {.count = count};
  return walk;
}

/// Goes to the next `step` paths, fewer at the end; on GPU devices to the one path of the queue's
/// entry. returns 0 at the end
EK_FN int path_walk_next(PathWalk* walk, global const uint* queue, uint step) {
  if (walk->next >= walk->count) return 0;
  walk->slot = EK_CHUNKED ? walk->next : queue[0];
  walk->lanes = EK_CHUNKED ? min(walk->count - walk->next, step) : 1u;
  walk->next = EK_CHUNKED ? walk->next + step : walk->count;
  return 1;
}

#endif
