// SPDX-License-Identifier: Apache-2.0
// The counter from which the work-items of one launch take paths.
#ifndef EK_PATH_COUNTER_H
#define EK_PATH_COUNTER_H
#include "lanes/lanes.h"

#if EK_CHUNKED
// Paths; a multiple of every width, since fewer leave lanes and rows of rays empty.
#define EK_LEAST_PORTION 256

/// The counter from which all work-items of the launch take paths; 0 before the launch.
typedef struct {
  global uint* next_path;
  uint path_count, workers;
} PathCounter;

/// Reserves the next paths of the unit for this work-item. returns how many; first: index of the
/// first
EK_FN uint paths_take(PathCounter counter, uint* first) {
  // The counter is read first only to size the portion, so it does no harm if others take paths in
  // between.
  const uint seen = *(volatile global uint*)counter.next_path;
  const uint left = seen < counter.path_count ? counter.path_count - seen : 0u;
  const uint share = left / (4u * counter.workers) / EK_LEAST_PORTION * EK_LEAST_PORTION;
  const uint portion = clamp(share, min((uint)EK_LEAST_PORTION, (uint)EK_CHUNK), (uint)EK_CHUNK);
  *first = atomic_add(counter.next_path, portion);
  return *first < counter.path_count ? min(counter.path_count - *first, portion) : 0u;
}
#endif

#endif
