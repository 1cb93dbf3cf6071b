// SPDX-License-Identifier: Apache-2.0
// Interval arithmetic in lanes. The result contains every value that a function of numbers in the
// operands' intervals has, both the exact value and the one that formula_math.h computes. Rounding
// is to the nearest, so every bound is moved outwards afterwards: by more than half a unit of the
// last place [Rump, Zimmermann, Boldo, Melquiond 2009, "Computing predecessor and successor in
// rounding to nearest", BIT 49(2)], or by the error of the function. Also by 2^-100, which covers
// what lies below 2^-126 whether or not a device keeps it, and makes the bits the same. lo is never
// NaN or +infinity, hi never NaN or -infinity; an interval that reaches infinity in a product or
// quotient is whole.
#ifndef EK_INTERVAL_H
#define EK_INTERVAL_H
#include "lanes/formula_math.h"

typedef struct { vf lo, hi; } Interval;

#define INTERVAL_UNIT 0x1.000002p-24f
#define INTERVAL_TINY 0x1p-100f

EK_FN Interval interval(vf lo, vf hi) {
  const Interval r = {lo, hi};
  return r;
}
EK_FN Interval interval_whole(void) { return interval(-EK_INFINITY, EK_INFINITY); }
EK_FN Interval interval_point(vf x) { return interval(x, x); }

// x moved down or up by `part` of itself and 2^-100; what is NaN or overflows becomes no bound.
EK_FN vf down_by(vf x, const float part) {
  const vf r = x - (abs_f(x) * part + INTERVAL_TINY);
  return r < EK_INFINITY ? r : -EK_INFINITY;
}
EK_FN vf up_by(vf x, const float part) {
  const vf r = x + (abs_f(x) * part + INTERVAL_TINY);
  return r > -EK_INFINITY ? r : EK_INFINITY;
}
EK_FN vf down(vf x) { return down_by(x, INTERVAL_UNIT); }
EK_FN vf up(vf x) { return up_by(x, INTERVAL_UNIT); }

EK_FN vi interval_finite(Interval a) { return is_finite(a.lo) & is_finite(a.hi); }
EK_FN Interval interval_hull(Interval a, Interval b) { return interval(min_f(a.lo, b.lo), max_f(a.hi, b.hi)); }
EK_FN Interval interval_select(vi m, Interval a, Interval b) { return interval(m ? a.lo : b.lo, m ? a.hi : b.hi); }

EK_FN Interval interval_neg(Interval a) { return interval(-a.hi, -a.lo); }
EK_FN Interval interval_add(Interval a, Interval b) { return interval(down(a.lo + b.lo), up(a.hi + b.hi)); }
EK_FN Interval interval_sub(Interval a, Interval b) { return interval(down(a.lo - b.hi), up(a.hi - b.lo)); }

// The interval of the four products or quotients of the ends. Their sum is not finite if one of
// them is not.
EK_FN Interval interval_of_four(vf p, vf q, vf r, vf s) {
  const vi finite = is_finite((p + q) + (r + s));
  return interval_select(finite, interval(down(min_f(min_f(p, q), min_f(r, s))), up(max_f(max_f(p, q), max_f(r, s)))),
                         interval_whole());
}
EK_FN Interval interval_mul(Interval a, Interval b) {
  return interval_of_four(a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi);
}
/// c * a for c > 0, finite.
EK_FN Interval interval_scale(vf c, Interval a) { return interval(down(c * a.lo), up(c * a.hi)); }
EK_FN Interval interval_div(Interval a, Interval b) {
  // Divisors closer to zero than 2^-100 may be flushed, or their quotients overflow.
  const vi apart = (b.lo > INTERVAL_TINY) | (b.hi < -INTERVAL_TINY);
  return interval_select(apart, interval_of_four(div_f(a.lo, b.lo), div_f(a.lo, b.hi), div_f(a.hi, b.lo), div_f(a.hi, b.hi)), interval_whole());
}

/// Bounds of |x|: least and most.
EK_FN Interval interval_abs(Interval a) {
  const vi straddles = (a.lo < 0.0f) & (a.hi > 0.0f);
  const vf l = abs_f(a.lo), h = abs_f(a.hi);
  return interval(straddles ? (vf)(0.0f) : min_f(l, h), max_f(l, h));
}
EK_FN Interval interval_min(Interval a, Interval b) { return interval(min_f(a.lo, b.lo), min_f(a.hi, b.hi)); }
EK_FN Interval interval_max(Interval a, Interval b) { return interval(max_f(a.lo, b.lo), max_f(a.hi, b.hi)); }
/// x where a < b, else y.
EK_FN Interval interval_choose(Interval a, Interval b, Interval x, Interval y) {
  return interval_select(a.hi < b.lo, x, interval_select(a.lo >= b.hi, y, interval_hull(x, y)));
}

// x^n for 0 <= x, from below and from above, in the order of formula_power.
EK_FN vf power_down(vf x, const uint n) {
  vf result = x, square = x;
  int begun = 0;
  for (uint rest = n; rest != 0u; rest >>= 1) {
    if ((rest & 1u) != 0u) {
      result = begun ? max_f(down(result * square), (vf)(0.0f)) : square;
      begun = 1;
    }
    square = max_f(down(square * square), (vf)(0.0f));
  }
  return result;
}
EK_FN vf power_up(vf x, const uint n) {
  vf result = x, square = x;
  int begun = 0;
  for (uint rest = n; rest != 0u; rest >>= 1) {
    if ((rest & 1u) != 0u) {
      result = begun ? up(result * square) : square;
      begun = 1;
    }
    square = up(square * square);
  }
  return result;
}
EK_FN Interval interval_power(Interval a, const uint n) {
  const Interval size = interval_abs(a);
  const vf least = power_down(size.lo, n), most = power_up(size.hi, n);
  if ((n & 1u) == 0u) return interval(least, most);
  // Monotone: each end goes with its own sign. Of an end's two roundings the outer one counts.
  const vf below = power_down(abs_f(a.hi), n), above = power_up(abs_f(a.lo), n);
  return interval(a.lo < 0.0f ? -above : power_down(abs_f(a.lo), n), a.hi < 0.0f ? -below : power_up(abs_f(a.hi), n));
}

/// If a has no number >= 0, there is no value, which the caller knows from interval_sqrt_undefined.
EK_FN Interval interval_sqrt(Interval a) {
  const vf zero = (vf)(0.0f);
  return interval(max_f(down(sqrt_f(max_f(a.lo, zero))), zero), up(sqrt_f(max_f(a.hi, zero))));
}
EK_FN_ONCE Interval interval_exp(Interval a) {
  return interval(max_f(down_by(formula_exp(a.lo), 0x1p-21f), (vf)(0.0f)), up_by(formula_exp(a.hi), 0x1p-21f));
}
EK_FN_ONCE Interval interval_log(Interval a) {
  const vf zero = (vf)(0.0f);
  return interval(down_by(formula_log(max_f(a.lo, zero)), 0x1p-21f), up_by(formula_log(max_f(a.hi, (vf)(INTERVAL_TINY))), 0x1p-21f));
}
EK_FN_ONCE Interval interval_atan(Interval a) {
  return interval(down_by(formula_atan(a.lo), 0x1p-20f), up_by(formula_atan(a.hi), 0x1p-20f));
}

// Largest integer that is not above x, |x| < 2^22.
EK_FN vf floor_small(vf x) {
  const vf nearest = (x + 12582912.0f) - 12582912.0f;
  return nearest > x ? nearest - 1.0f : nearest;
}
// The lanes whose [a, b] contains an integer; true in doubt.
EK_FN vi holds_integer(vf a, vf b) { return floor_small(b + (abs_f(b) * 0x1p-21f + 0x1p-20f)) >= a - (abs_f(a) * 0x1p-21f + 0x1p-20f); }

// Bounds of a sine wave. shift: the place of its maxima, in turns; at_lo, at_hi: its values at the
// ends of a
EK_FN Interval interval_wave(Interval a, vf at_lo, vf at_hi, const float shift) {
  const vi usable = (a.lo >= -FORMULA_ANGLE_LIMIT) & (a.hi <= FORMULA_ANGLE_LIMIT);
  const vf lo = usable ? a.lo * 0x1.45f306p-3f : (vf)(0.0f), hi = usable ? a.hi * 0x1.45f306p-3f : (vf)(0.0f);
  const vf one = (vf)(1.0f);
  const vf least = max_f(min_f(at_lo, at_hi) - 0x1p-22f, -one), most = min_f(max_f(at_lo, at_hi) + 0x1p-22f, one);
  const Interval inner = interval(holds_integer(lo - (shift + 0.5f), hi - (shift + 0.5f)) ? -one : least,
                                  holds_integer(lo - shift, hi - shift) ? one : most);
  return interval_select(usable, inner, interval_whole());
}
EK_FN_ONCE Interval interval_sin(Interval a) { return interval_wave(a, formula_sin(a.lo), formula_sin(a.hi), 0.25f); }
EK_FN_ONCE Interval interval_cos(Interval a) { return interval_wave(a, formula_cos(a.lo), formula_cos(a.hi), 0.0f); }

// The lanes in which the function has no value for any number of a.
EK_FN vi interval_sqrt_undefined(Interval a) { return a.hi < 0.0f; }
EK_FN vi interval_log_undefined(Interval a) { return a.hi < 0.0f; }

#endif
