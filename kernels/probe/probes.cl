// SPDX-License-Identifier: Apache-2.0
// The checks that a device must pass before a render trusts it. They share one kernel, because each
// kernel has a fixed cost in a driver's compiler.
#include "probe/arithmetic.h"
#include "probe/canary.h"

kernel void probes(global uint* canary_out, global const Triangle* canary_triangles, global const uint* canary_other,
                   global const uint* canary_words, global const float* canary_floats, global uint* arithmetic_out,
                   global const uint* arithmetic_records) {
  canary_run(canary_out, canary_triangles, canary_other, canary_words, canary_floats);
  arithmetic_run(arithmetic_out, arithmetic_records);
}
