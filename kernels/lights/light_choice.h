// SPDX-License-Identifier: Apache-2.0
// Choosing by an alias table: among lights, and among the texels of the environment's map.
#ifndef EK_LIGHT_CHOICE_H
#define EK_LIGHT_CHOICE_H
#include "lanes/sampler.h"

// A word as the nearest float: both parts are exact. Devices do not agree on converting what does not fit an int.
EK_FN vf word_to_float(vu x) { return TO_F(AS_I(x >> 16)) * 65536.0f + TO_F(AS_I(x & 0xffffu)); }

typedef struct {
  vu light;
  vf u, v;  // what is left of the sample, [0,1)^2
} LightChoice;

/// Chooses an entry of a table (host/pack/lights/light_table.h), and gives back the random words for reuse.
/// light_count  entries; 0: entry 0 of whatever is there
/// a, b         pair of sample_2d_bits
// The bucket takes the leading part of `a`, so that strata of `a` are strata of lights; the rest, rescaled, is again
// uniform within the light. With n buckets it has 2^32 / n values only, fewer for an unlikely light: the low bits of
// `b`, which v does not use, fill the gaps between them, so that it is even to within the share of one value.
EK_FN LightChoice choose_light(global const LightBucket* buckets, uint light_count, vu a, vu b) {
  const vu bucket = mul_hi(a, (vu)(light_count));
  const vu rest = a * light_count;
  global const uint* words = (global const uint*)buckets;
  const vu threshold = gather_u(words, bucket * 2u);
  const vu alias = gather_u(words, bucket * 2u + 1u);
  const vi own = rest < threshold;
  const vf place = TO_F(own ? rest : rest - threshold) + TO_F(mul_hi(b << 24, (vu)(light_count)));
  vf u = place / (own ? TO_F(threshold) : TO_F(~threshold) + 1.0f);
  u = u < 1.0f ? u : u - 1.0f;  // the last value's gap reaches over the end: it fills the first one's
  LightChoice c = {own ? bucket : alias, min_f(u, (vf)(1.0f - 0x1p-24f)), to_unit_float(b)};
  return c;
}

#endif
