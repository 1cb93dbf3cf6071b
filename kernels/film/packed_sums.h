// SPDX-License-Identifier: Apache-2.0
// Packs film sums for their way to the host (shared/packed_sums.h), one pixel at a time.
#ifndef EK_PACKED_SUMS_H
#define EK_PACKED_SUMS_H
#include "film/fixed_point.h"
#include "lanes/simd.h"
#include "shared/packed_sums.h"

#if EK_WIDTH == 1
typedef struct {
  uint low, high;  // together a signed number
  uint shift;      // the sum is that number times 2^shift
  uint is_wide;    // 1: the sum does not fit
} PackedSum;

EK_FN PackedSum pack_sum(Fixed sum) {
  const uint sign = (sum.limb[EK_FILM_LIMBS - 1] >> 31) != 0u ? 0xffffffffu : 0u;
  PackedSum packed = {0u, 0u, 0u, 0u};
  // Whole words of zeros first.
#pragma unroll
  for (int i = 0; i + 1 < EK_FILM_LIMBS; ++i) {
    if (sum.limb[0] != 0u) break;
    for (int k = 0; k + 1 < EK_FILM_LIMBS; ++k) sum.limb[k] = sum.limb[k + 1];
    sum.limb[EK_FILM_LIMBS - 1] = sign;
    packed.shift += 32u;
  }
  if (sum.limb[0] == 0u) {  // it is zero
    packed.shift = 0u;
    return packed;
  }
  const uint bits = lowest_bit(sum.limb[0]);
  packed.shift += bits;
  if (bits != 0u)
    for (int k = 0; k < EK_FILM_LIMBS; ++k)
      sum.limb[k] = sum.limb[k] >> bits | (k + 1 < EK_FILM_LIMBS ? sum.limb[k + 1] : sign) << (32u - bits);
  packed.low = sum.limb[0];
  packed.high = sum.limb[1];
  const uint above = (sum.limb[1] >> 31) != 0u ? 0xffffffffu : 0u;
  packed.is_wide = (above != sign) | (sum.limb[2] != sign) | (sum.limb[3] != sign);
  return packed;
}

#endif

#endif
