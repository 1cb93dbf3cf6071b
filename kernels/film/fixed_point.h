// SPDX-License-Identifier: Apache-2.0
// The fixed-point numbers in which the film adds floats exactly: 128-bit two's-complement integers
// of unit 2^-64, in four 32-bit limbs, the low one first.
#ifndef EK_FIXED_POINT_H
#define EK_FIXED_POINT_H
#include "lanes/math.h"

typedef struct { vu limb[EK_FILM_LIMBS]; } Fixed;

/// Tells values that are finite and so small that 2^24 of them do not overflow: |x| < 2^38.
EK_FN vi fixed_in_range(vf x) { return (AS_U(x) & 0x7f800000u) < (vu)(165u << 23); }

/// x, or the nearest value in range.
EK_FN vf fixed_clamped(vf x) { return min_f(max_f(x, (vf)(-0x1.fffffep37f)), (vf)(0x1.fffffep37f)); }

/// floor(x * 2^64) of an x in range. It is made of integer shifts instead of conversions, so every
/// device gives the same bits.
EK_FN Fixed fixed_from_float(vf x) {
  const vu bits = AS_U(x);
  const vi exponent = AS_I((bits >> 23) & 0xffu);
  const vi normal = exponent != 0;
  const vu mantissa = (bits & 0x007fffffu) | (normal ? (vu)(0x00800000u) : (vu)(0u));
  // x = mantissa * 2^(exponent - 150), and the unit is 2^-64.
  const vi shift = (normal ? exponent : (vi)(1)) - 86;
  const vi negative = (bits & 0x80000000u) != 0u;
  const vi cut = shift < 0;
  const vu lost = AS_U(-shift) < 32u ? mantissa & ((vu)(1u) << AS_U(-shift)) - 1u : mantissa;
  const vi inexact = cut & (lost != 0u);
  // -(m + fraction) rounds down to ~m when there is a fraction, and is ~m + 1 when there is none.
  vu carry = (negative & !inexact) ? (vu)(1u) : (vu)(0u);
  Fixed fixed;
#pragma unroll
  for (int i = 0; i < EK_FILM_LIMBS; ++i) {
    const vi left = shift - 32 * i;
    const vu up = left < 32 ? mantissa << AS_U(left & 31) : (vu)(0u);
    const vu down = left > -32 ? mantissa >> AS_U(-left & 31) : (vu)(0u);
    const vu magnitude = left >= 0 ? up : down;
    const vu word = (negative ? ~magnitude : magnitude) + carry;
    carry = word < carry ? (vu)(1u) : (vu)(0u);
    fixed.limb[i] = word;
  }
  return fixed;
}

/// a + b, modulo 2^128 units.
EK_FN Fixed fixed_add(Fixed a, Fixed b) {
  vu carry = (vu)(0u);
#pragma unroll
  for (int i = 0; i < EK_FILM_LIMBS; ++i) {
    const vu partial = a.limb[i] + b.limb[i];
    const vu word = partial + carry;
    carry = ((partial < a.limb[i]) | (word < partial)) ? (vu)(1u) : (vu)(0u);
    a.limb[i] = word;
  }
  return a;
}

#endif
