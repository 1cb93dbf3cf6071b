// SPDX-License-Identifier: Apache-2.0
// Sampling of a discrete distribution by an alias table [Walker 1974; Vose 1991]. Lights use it,
// and the texels of the environment map.
#ifndef EK_ALIAS_TABLE_H
#define EK_ALIAS_TABLE_H
#include "lanes/math.h"
#include "lanes/record_lanes.h"
#include "lanes/sampler.h"

// A word as the nearest float, of two exact parts: devices differ in converting what does not fit
// an int.
EK_FN vf word_to_float(vu x) { return TO_F(AS_I(x >> 16)) * 65536.0f + TO_F(AS_I(x & 0xffffu)); }

typedef struct {
  vu index;
  vf u, v;  // the rest of the sample, uniform again, [0,1)^2
} AliasSample;

/// Chooses an entry of a table (host/pack/lights/light_table.h), and returns the words for reuse.
/// count  of entries; 0: the index is 0
/// a, b   pair of sample_2d_bits
// The leading part of `a` selects the entry, so that strata of `a` are strata of entries. The rest,
// rescaled, is uniform again. With n entries it has only 2^32 / n values, and fewer for an unlikely
// index: the low bits of `b`, which v does not use, fill the gaps between them, so that u is
// uniform to within the share of one value.
EK_FN AliasSample alias_table_sample(global const AliasEntry* table, uint count, vu a, vu b) {
  const vu entry = mul_hi(a, (vu)(count));
  const vu rest = a * count;
  const vu threshold = load_word_u(AliasEntry, table, entry, threshold);
  const vu alias = load_word_u(AliasEntry, table, entry, alias);
  const vi own = rest < threshold;
  const vf place = TO_F(own ? rest : rest - threshold) + TO_F(mul_hi(b << 24, (vu)(count)));
  vf u = div_f(place, own ? TO_F(threshold) : TO_F(~threshold) + 1.0f);
  u = u < 1.0f ? u : u - 1.0f;  // the last value's gap fills the first one's
  AliasSample s = {own ? entry : alias, min_f(u, (vf)(1.0f - 0x1p-24f)), to_unit_float(b)};
  return s;
}

#endif
