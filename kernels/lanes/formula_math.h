// SPDX-License-Identifier: Apache-2.0
// The functions that a formula may name, in lanes; host/formula compiles the same text, so that it
// computes the same bits. A function without a value results in NaN. Numbers below 2^-126 count as
// 0, because devices differ in them. On wide devices these functions are called, not inlined,
// because formulas would take minutes to compile. The error bounds are those that interval.h relies
// on; the tests hold them against double.
#ifndef EK_FORMULA_MATH_H
#define EK_FORMULA_MATH_H
#include "lanes/math.h"

#define FORMULA_NAN AS_F((vu)(0x7fc00000u))
#define FORMULA_ANGLE_LIMIT 102000.0f  // radians: beyond, neighbouring floats are further apart than a hundredth

/// sin and cos of x radians, |x| <= FORMULA_ANGLE_LIMIT, else NaN. Each within 2^-23 absolute.
/// source  polynomials of cephes' sinf, cosf [Moshier 1989]; a quarter turn in four parts, of which
///         three have 8 bits, so that their products with the number of quarters are exact
EK_FN void formula_sincos(vf x, vf* s, vf* c) {
  const vi usable = abs_f(x) <= FORMULA_ANGLE_LIMIT;
  const vf angle = usable ? x : (vf)(0.0f);
  const vf quarters = (angle * 0x1.45f306p-1f + 12582912.0f) - 12582912.0f;  // to the nearest integer
  const vf r = (((angle - quarters * 0x1.92p+0f) - quarters * 0x1.fap-12f) - quarters * 0x1.54p-20f) - quarters * 0x1.10b462p-30f;
  const vf z = r * r;
  const vf near_s = r + (r * z) * (-0x1.555546p-3f + z * (0x1.11073cp-7f + z * -0x1.9943f2p-13f));
  const vf near_c = (1.0f - 0.5f * z) + (z * z) * (0x1.55554ap-5f + z * (-0x1.6c0c34p-10f + z * 0x1.99eb9cp-16f));
  const vi quadrant = TO_I(quarters);
  const vi odd = (quadrant & 1) != 0;
  const vf sine = odd ? near_c : near_s;
  const vf cosine = odd ? near_s : near_c;
  *s = usable ? ((quadrant & 2) != 0 ? -sine : sine) : FORMULA_NAN;
  *c = usable ? (((quadrant + 1) & 2) != 0 ? -cosine : cosine) : FORMULA_NAN;
}
EK_FN_ONCE vf formula_sin(vf x) {
  vf s, c;
  formula_sincos(x, &s, &c);
  return s;
}
EK_FN_ONCE vf formula_cos(vf x) {
  vf s, c;
  formula_sincos(x, &s, &c);
  return c;
}

/// e^x, within 2^-22 of itself; 0 below -87, infinite from 88.722839 on; NaN of NaN.
/// source  polynomial of cephes' expf
EK_FN_ONCE vf formula_exp(vf x) {
  const vf bounded = max_f(min_f(x, (vf)(89.0f)), (vf)(-88.0f));  // and NaN becomes a number
  const vf k = (bounded * 0x1.715476p+0f + 12582912.0f) - 12582912.0f;
  const vf r = (bounded - k * 0.693359375f) - k * -2.12194440e-4f;
  const vf p = 5.0000001201e-1f +
               r * (1.6666665459e-1f +
                    r * (4.1665795894e-2f + r * (8.3334519073e-3f + r * (1.3981999507e-3f + r * 1.9875691500e-4f))));
  const vf y = 1.0f + (r + (r * r) * p);
  // In two steps: 2^128 is not a float.
  const vi whole = TO_I(k), half_exponent = whole / 2;
  const vf a = AS_F(AS_U(half_exponent + 127) << 23), b = AS_F(AS_U(whole - half_exponent + 127) << 23);
  const vf scaled = x < -87.0f ? (vf)(0.0f) : x > 88.722839f ? EK_INFINITY : (y * a) * b;
  return x == x ? scaled : FORMULA_NAN;
}

/// Natural logarithm, within 2^-22 of itself; minus infinity of 0 (and below 2^-126), NaN of what
/// is less.
/// source  polynomial of cephes' logf
EK_FN_ONCE vf formula_log(vf x) {
  const vi usable = (x >= 0x1p-126f) & (x < EK_INFINITY);
  const vu bits = AS_U(usable ? x : (vf)(1.0f));
  // x = m 2^e with m in [sqrt(1/2), sqrt(2)): the exponent counts from the bits of sqrt(1/2).
  const vi e = AS_I(bits - 0x3f3504f3u) >> 23;
  const vf m = AS_F(bits - AS_U(e << 23)) - 1.0f;
  const vf z = m * m;
  const vf p =
      3.3333331174e-1f +
      m * (-2.4999993993e-1f +
           m * (2.0000714765e-1f +
                m * (-1.6668057665e-1f +
                     m * (1.4249322787e-1f +
                          m * (-1.2420140846e-1f + m * (1.1676998740e-1f + m * (-1.1514610310e-1f + m * 7.0376836292e-2f)))))));
  const vf whole = TO_F(e);
  const vf tail = ((m * z) * p + whole * -2.12194440e-4f) - 0.5f * z;
  const vf y = (m + tail) + whole * 0.693359375f;
  const vf low = x > -0x1p-126f ? -EK_INFINITY : FORMULA_NAN;
  return usable ? y : (x >= 0x1p-126f ? x : low);
}

/// Angle in radians, within 2^-21 of itself.
EK_FN_ONCE vf formula_atan(vf x) {
  const vi large = abs_f(x) > 0x1p+100f;
  const vf angle = 0x1.921fb6p+2f * atan2_turns(large ? copysign_f((vf)(0x1p+100f), x) : x, (vf)(1.0f));
  return x == x ? angle : FORMULA_NAN;
}

/// x^n by squaring; n >= 1. The order of the products is fixed.
EK_FN vf formula_power(vf x, const uint n) {
  vf result = x, square = x;
  int begun = 0;
  for (uint rest = n; rest != 0u; rest >>= 1) {
    if ((rest & 1u) != 0u) {
      result = begun ? result * square : square;
      begun = 1;
    }
    square = square * square;
  }
  return result;
}

#endif
