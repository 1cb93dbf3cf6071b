// SPDX-License-Identifier: Apache-2.0
// Division and square root, rounded correctly so that all devices give the same bits. Kernels use
// them instead of `/` and `sqrt`, but for constants, which compilers divide exactly.
//
// Drivers promise correct rounding under a flag. With EK_OWN_DIVISION kernels of one lane do not
// rely on that: some drivers promise nothing, and Intel's for GPUs makes 75 instructions of each
// division, so that the code of a shading stage takes 200 to 450 kB and its compiler up to 15 s.
// What is below takes a quarter of that.
//
// Correctly rounded are all results that are not denormal, of operands that are not: nothing in the
// kernels depends on denormal numbers, which devices may flush. Two quotients are left open: a
// number over a denormal one may be infinite or NaN, and so may infinity over a number beyond
// 2^126, whose reciprocal is denormal.
#ifndef EK_DIVISION_H
#define EK_DIVISION_H
#include "lanes/lanes.h"

#if !defined(EK_OWN_DIVISION) || EK_WIDTH > 1

#define div_f(a, b) ((a) / (b))
#define sqrt_f(x) sqrt(x)

#else

// These are first guesses, which differ between devices by some units in the last place. No result
// shows which guess it came from, as the proof below says. Tests replace them by worse ones.
#ifndef EK_GUESS_RECIPROCAL
#define EK_GUESS_RECIPROCAL native_recip
#define EK_GUESS_RECIPROCAL_ROOT native_rsqrt
#endif

// The first gives the exponent of a float in its place, and the second is true if a number with it
// is not 0, denormal, infinite or NaN.
EK_FN uint exponent_bits(float x) { return as_uint(x) & 0x7f800000u; }
EK_FN bool is_normal_exponent(uint bits) { return bits - 0x00800000u < 0x7f000000u; }

/// 1 / b for 1 <= |b| < 2, to 2^-24 / |b| or better. An iteration of Newton's with its next term,
/// e^2: reciprocals of numbers just below 2 lie nearly halfway between two floats, and the wrong
/// one of them gives wrong quotients: 1 / 1.99999988 would be 0.5. What is added to e decides where
/// the rounding of e + e^2 has lost that.
EK_FN float reciprocal_between_1_and_2(float b) {
  const float guess = EK_GUESS_RECIPROCAL(b), e = fma(-b, guess, 1.0f);
  return fma(guess, fma(e, e, e + 0x1p-46f), guess);
}

/// a / b for 1 <= |a|, |b| < 2, correctly rounded: a product with the reciprocal is corrected twice
/// by its exact remainder [Markstein 1990, IBM Journal of Research and Development 34(1)].
///
/// The proof counts in units of the last place of the quotient x. After the first correction the
/// quotient q is at most 1/2 + 2^-22 from x, so its remainder is an integer below 2^24 and exact.
/// The last correction rounds x + (x - q) e, where e is the relative error of the reciprocal. With
/// B = 2^23 |b|, a fraction of integers over B, x is d >= 1 / (2 B) from the middle between two
/// floats, since B < 2^24 is not divisible by 2^24. If q is the float beyond that middle, |x - q| =
/// 1/2 + d, and rounding is right if (1/2 + d) |e| < d; that follows from |e| (B + 1) < 1. If q is
/// on the same side, less is enough. The condition holds for all b with guesses up to 8 units in
/// the last place off (the test `Division.*` tries nine such guesses for each b).
EK_FN float div_between_1_and_2(float a, float b) {
  const float r = reciprocal_between_1_and_2(b);
  float q = a * r;
  q = fma(fma(-b, q, a), r, q);
  return fma(fma(-b, q, a), r, q);
}

EK_FN float div_f(float a, float b) {
  const uint exponent_a = exponent_bits(a), exponent_b = exponent_bits(b);
  const float q = div_between_1_and_2(as_float((as_uint(a) & 0x807fffffu) | 0x3f800000u), as_float((as_uint(b) & 0x807fffffu) | 0x3f800000u));
  const uint exponent = exponent_bits(q) + exponent_a - exponent_b;
  const bool usual = is_normal_exponent(exponent_a) & is_normal_exponent(exponent_b) & is_normal_exponent(exponent);
  // Otherwise an operand is 0, infinite or NaN, or the quotient is beyond the range. The guess is
  // infinite for 0 and 0 for infinity. The factor above 1 makes sure that a quotient which is
  // rounded to infinity gets there.
  return usual ? as_float(as_uint(q) + exponent_a - exponent_b) : a * (EK_GUESS_RECIPROCAL(b) * 1.00001f);
}

/// The square root of 1/2 <= x < 2, correctly rounded, by Goldschmidt's iteration and a correction
/// by the remainder [Markstein 1990]. That no root is wrong is known from the test, which tries
/// every x with such guesses.
EK_FN float sqrt_between_half_and_2(float x) {
  const float guess = EK_GUESS_RECIPROCAL_ROOT(x);
  float root = x * guess, half_reciprocal = 0.5f * guess;
  const float rest = fma(-root, half_reciprocal, 0.5f);
  root = fma(root, rest, root);
  half_reciprocal = fma(half_reciprocal, rest, half_reciprocal);
  return fma(fma(-root, root, x), half_reciprocal, root);
}

EK_FN float sqrt_f(float x) {
  // The last bit of the exponent says which half of the range x has.
  const uint bits = as_uint(x), last = bits & 0x00800000u;
  const uint near = 0x3f000000u + last;                     // the exponent of a number between 1/2 and 2
  const float root = sqrt_between_half_and_2(as_float((bits & 0x007fffffu) | near));
  const int half_exponent = as_int((bits & 0x7f800000u) - near) >> 1;
  // With the sign, which makes the exponents of negative numbers too large.
  const bool usual = is_normal_exponent(bits & 0xff800000u);
  return usual ? as_float(as_uint(root) + as_uint(half_exponent)) : x < 0.0f ? as_float(0x7fc00000u) : x;
}

#endif
#endif
