// SPDX-License-Identifier: Apache-2.0
// The paths of a pilot write a log, from which the host learns where light comes from
// (host/guide/learner.h). It has the words LOG_* of each of their first EK_LOG_DEPTHS vertices:
//   path_log[((depth - 1) * LOG_WORDS + word) * stride + path]
#ifndef EK_PATH_LOG_H
#define EK_PATH_LOG_H
#include "lanes/math.h"
#include "shared/guide.h"

typedef struct {
  global uint* words;
  uint stride;  // paths per word, padded
} PathLog;

#if EK_HAS_path_log
#define EK_LOG_ARGUMENT , global uint *path_log
#define EK_LOG {path_log, frame->film_stride}
#else
#define EK_LOG_ARGUMENT
#define EK_LOG {0, 0u}
#endif

/// Sets one word of the vertex at a depth of the paths of the mask `live`. Lanes without a path
/// write to the padding.
EK_FN void log_set(PathLog log, uint depth, uint word, vi live, vu path, vu value) {
  if (depth > EK_LOG_DEPTHS) return;
#if EK_WIDTH == 1
  if (!live) return;
#endif
  global uint* plane = log.words + (size_t)((depth - 1u) * LOG_WORDS + word) * log.stride;
  const vu slot = live ? path : (vu)(log.stride - EK_PAD) + LANE_INDEX;
  scatter_f((global float*)plane, slot, AS_F(value));
}
EK_FN void log_set_f(PathLog log, uint depth, uint word, vi live, vu path, vf value) {
  log_set(log, depth, word, live, path, AS_U(value));
}

/// The share of the luminance of a path's throughput that is left after a step of it.
EK_FN vf log_share(v3 before, v3 after) {
  const vf whole = luminance(abs3(before));
  return whole > 0.0f ? div_f(luminance(abs3(after)), whole) : (vf)(0.0f);
}

#endif
