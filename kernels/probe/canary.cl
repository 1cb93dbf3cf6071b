// SPDX-License-Identifier: Apache-2.0
// The memory probe alone.
#include "probe/canary.h"

kernel void canary(global uint* canary_out, global const Triangle* canary_triangles, global const uint* canary_other,
                   global const uint* canary_words, global const float* canary_floats) {
  canary_run(canary_out, canary_triangles, canary_other, canary_words, canary_floats);
}
