// SPDX-License-Identifier: Apache-2.0
// Surfaces f(x, y, z) = 0 by a formula, within bounds. The formula's functions are written by
// host/formula/kernel_code.cpp and stand at the end of the program. The first root of f(o + s d) is
// found by halving: of a piece of the ray, interval arithmetic says
//   - that f has no root or no value in it: on to the next one;
//   - that f is monotone along it: then there is at most one root, which there is if the signs at
//     its ends differ. Neighbouring pieces compute the same sign for the point between them, and
//     intervals enclose what is computed, so no root is lost or found twice;
//   - neither: its halves, the nearer one first.
// A piece in which f may be 0, and which is as short as floats can resolve, counts as a root: there
// f touches 0, or nearly does. Halves are visited depth first without a stack: behind a piece that
// is done follows the largest one that begins there and is aligned to its size. Nothing is
// absolute: the ray begins where it enters the bounds, and d is scaled by a power of two.
#ifndef EK_IMPLICIT_H
#define EK_IMPLICIT_H
#include "lanes/interval.h"

#define IMPLICIT_PIECES 0x1000000u  // of the shortest length, in a whole search

// Bounds of f, and of its derivative along a direction, on a box.
typedef struct {
  Interval value, slope;
  vi undefined;  // f has no value anywhere in it
} ImplicitBounds;

EK_FN vf implicit_value(uint formula, v3 p);
EK_FN v3 implicit_gradient(uint formula, v3 p);
EK_FN ImplicitBounds implicit_bounds(uint formula, Interval x, Interval y, Interval z, v3 d);

// A ray in the formula's coordinates from where it enters the bounds.
typedef struct {
  v3 o, d;       // the largest component of d is in [1, 2)
  vf begin;      // from the ray's own origin to o, in lengths of d
  vf length;     // to where it leaves the bounds; not above 0: it passes them by
  vf per_length; // t of a length of d
  vf reach;      // largest coordinate within the bounds
} ImplicitRay;

typedef struct {
  vi hit;
  vf s;          // from ImplicitRay.o, in lengths of d; where hit, or where it was given up
  vi given_up;   // after EK_IMPLICIT_STEPS
} ImplicitRoot;

// o + s d to the last place, however far o is: the product's and the sum's errors are exact [Dekker
// 1971; Knuth].
EK_FN vf exact_step(vf o, vf d, vf s) {
  const vf product = d * s, sum = o + product;
  const vf d_hi = AS_F(AS_U(d) & 0xfffff000u), s_hi = AS_F(AS_U(s) & 0xfffff000u), d_lo = d - d_hi, s_lo = s - s_hi;
  const vf product_rest = (((d_hi * s_hi - product) + d_hi * s_lo) + d_lo * s_hi) + d_lo * s_lo;
  const vf o_part = sum - product, product_part = sum - o_part;
  return sum + (((o - o_part) + (product - product_part)) + product_rest);
}

EK_FN v3 along(v3 o, v3 d, vf s) { return V3(o.x + d.x * s, o.y + d.y * s, o.z + d.z * s); }

// Narrows [begin, end] to where the ray is within [lo, hi] on one axis.
EK_FN void clip_axis(vf o, vf d, vf lo, vf hi, vf* begin, vf* end) {
  const vf least = (vf)(0x1p-80f);
  const vf r = div_f((vf)(1.0f), abs_f(d) < least ? (d < 0.0f ? -least : least) : d);
  const vf a = (lo - o) * r, b = (hi - o) * r;
  *begin = max_f(min_f(a, b), *begin);
  *end = min_f(max_f(a, b), *end);
}

/// The ray (o, d), d of any length, 0 < t, clipped to [lo, hi]; all in the formula's coordinates.
EK_FN ImplicitRay implicit_ray(v3 o, v3 d, v3 lo, v3 hi) {
  ImplicitRay ray;
  const vf size = max_component(abs3(d));
  const vi usable = (size >= 0x1p-124f) & (size < 0x1p+125f);
  ray.per_length = usable ? inverse_power_of_two(size) : (vf)(1.0f);
  ray.d = scale3(d, ray.per_length);
  ray.reach = max_f(max_component(abs3(lo)), max_component(abs3(hi)));
  vf begin = (vf)(0.0f), end = (vf)(0x1p+120f);
  clip_axis(o.x, ray.d.x, lo.x, hi.x, &begin, &end);
  clip_axis(o.y, ray.d.y, lo.y, hi.y, &begin, &end);
  clip_axis(o.z, ray.d.z, lo.z, hi.z, &begin, &end);
  // The slack keeps a surface that lies in a side of its bounds from flickering by their rounding.
  const vf slack = ray.reach * 0x1p-21f + max_component(abs3(o)) * 0x1p-22f;
  const vi passes = begin - slack <= end + slack;
  ray.begin = max_f(begin - slack, (vf)(0.0f));
  ray.o = V3(exact_step(o.x, ray.d.x, ray.begin), exact_step(o.y, ray.d.y, ray.begin), exact_step(o.z, ray.d.z, ray.begin));
  ray.length = (usable & passes) ? (end + slack) - ray.begin : (vf)(0.0f);
  return ray;
}

// The most by which rounding moves a point of the ray on each axis: half a unit of a product of at
// most 2 reach and of a sum of reach.
EK_FN vf implicit_pad(ImplicitRay ray) { return ray.reach * 0x1p-22f; }

EK_FN Interval between(vf a, vf b, vf pad) { return interval(min_f(a, b) - pad, max_f(a, b) + pad); }

// Narrows [a, b], at whose ends f has different signs, to what floats can tell: false position
// [Dowell, Jarratt 1971], a bisection where that has not halved it. returns where |f| is least of
// what was tried
EK_FN vf implicit_narrow(uint formula, ImplicitRay ray, vi live, vf a, vf b) {
  const vf least = ray.reach * 0x1p-24f;
  vf fa = implicit_value(formula, along(ray.o, ray.d, a)), fb = implicit_value(formula, along(ray.o, ray.d, b));
  vf best = abs_f(fa) < abs_f(fb) ? a : b, best_size = min_f(abs_f(fa), abs_f(fb));
  vf goal = b - a;  // what the next step is to come below
  vi kept_a = (vi)(0), kept_b = (vi)(0);
  for (uint i = 0; i < 64u; ++i) {
    const vf middle = a + (b - a) * 0.5f;
    // At least so far from the ends that the root comes to lie between two points as close as that.
    const vf guess = min_f(max_f(a + (b - a) * div_f(fa, fa - fb), a + least), b - least);
    const vi usable = (guess > a) & (guess < b) & (b - a <= goal);
    const vf m = usable ? guess : middle;
    goal = (b - a) * 0.5f;
    live = live & (b - a > least) & (m > a) & (m < b) & (best_size > 0.0f);
    if (!ANY(live)) break;
    const vf fm = implicit_value(formula, along(ray.o, ray.d, m));
    const vi better = live & (abs_f(fm) < best_size);
    best = better ? m : best;
    best_size = better ? abs_f(fm) : best_size;
    const vi left = (fm < 0.0f) == (fa < 0.0f);  // the root is behind m
    const vi move_a = live & left, move_b = live & !left;
    a = move_a ? m : a;
    b = move_b ? m : b;
    // An end that stays twice running counts half, so that the other one comes over.
    fa = move_a ? fm : (move_b & kept_a) ? fa * 0.5f : fa;
    fb = move_b ? fm : (move_a & kept_b) ? fb * 0.5f : fb;
    kept_a = move_b;
    kept_b = move_a;
  }
  return best;
}

/// The first root of f on the ray, of the lanes of `live`; in those of `culls`, the first one
/// before which f is not negative. until: what lies farther, in lengths of d from ImplicitRay.o, is
/// of no use
EK_FN ImplicitRoot implicit_root(uint formula, ImplicitRay ray, vi live, vi culls, vf until) {
  const vf unit = ray.length * 0x1p-24f, resolution = ray.reach * 0x1p-23f, pad = implicit_pad(ray);
  vi open = live & (ray.length > 0.0f), crosses = (vi)(0);
  vu at = (vu)(0u), size = (vu)(IMPLICIT_PIECES);
  vf a = (vf)(0.0f), b = (vf)(0.0f);
  ImplicitRoot root;
  root.hit = (vi)(0);
  root.given_up = (vi)(0);
  for (uint step = 0; ANY(open); ++step) {
    const vf begin = TO_F(AS_I(at)) * unit;
    open = open & (begin <= until);
    if (step == EK_IMPLICIT_STEPS) {
      root.given_up = open;
      break;
    }
    const vf end = TO_F(AS_I(at + size)) * unit;
    const v3 p = along(ray.o, ray.d, begin), q = along(ray.o, ray.d, end);
    const ImplicitBounds bounds = implicit_bounds(formula, between(p.x, q.x, pad), between(p.y, q.y, pad), between(p.z, q.z, pad), ray.d);
    const vi rootless = (bounds.value.lo > 0.0f) | (bounds.value.hi < 0.0f) | bounds.undefined;
    const vi monotone = (bounds.slope.lo > 0.0f) | (bounds.slope.hi < 0.0f);
    const vi shortest = (size == 1u) | (end - begin <= resolution);
    vi found = open & !rootless & !monotone & shortest & interval_finite(bounds.value);
    const vi candidate = open & !rootless & monotone;
    if (EK_HAS_culling && ANY(found & culls)) found = found & !(culls & (implicit_value(formula, p) < 0.0f));
    if (ANY(candidate)) {
      const vi negative = implicit_value(formula, p) < 0.0f;
      vi signs = negative != (implicit_value(formula, q) < 0.0f);
      if (EK_HAS_culling) signs = signs & !(culls & negative);
      const vi crossing = candidate & signs;
      crosses = crosses | crossing;
      found = found | crossing;
    }
    a = found ? begin : a;
    b = found ? end : b;
    root.hit = root.hit | found;
    const vi done = rootless | monotone | shortest;
    at = done ? at + size : at;
    size = done ? at & (0u - at) : size >> 1;
    open = open & !found & (at < IMPLICIT_PIECES);
  }
  root.s = root.given_up ? TO_F(AS_I(at)) * unit : a + (b - a) * 0.5f;
  if (ANY(crosses)) {
    const vf s = implicit_narrow(formula, ray, crosses, a, b);
    root.s = crosses ? s : root.s;
  }
  return root;
}

// The point where the ray meets the surface, in the formula's coordinates.
typedef struct {
  v3 p, n;  // n: unit, to where f > 0
  vf error; // how far a ray that leaves must start from p along n or against it, so that it does not meet f = 0 at once
} ImplicitPoint;

/// The point at root `s` of the ray, of the lanes of `live`. noise: what a point may be moved by on
/// each axis on its way to the world and back.
// Starting points are pushed away until intervals say that f is not 0 there: what f's own rounding
// cannot tell from the surface is different for each formula, and from point to point.
EK_FN ImplicitPoint implicit_point(uint formula, ImplicitRay ray, vi live, vf s, vf noise) {
  ImplicitPoint r;
  r.p = along(ray.o, ray.d, s);
  const v3 gradient = implicit_gradient(formula, r.p);
  const vf size = max_component(abs3(gradient));
  const vi usable = is_finite(gradient.x) & is_finite(gradient.y) & is_finite(gradient.z) & (size > 0x1p-100f);
  // Where f has no slope no side is outwards, and the viewer's is as good as any. Scaling by a
  // power of two keeps squares in range.
  const vf down_scale = inverse_power_of_two(usable ? min_f(size, (vf)(0x1p+100f)) : (vf)(1.0f));
  r.n = normalize3(select3(usable, scale3(gradient, down_scale), neg3(ray.d)));
  // Twice the pad of a search: a ray that runs along the surface at this height is not to meet it
  // elsewhere either.
  const vf pad = 2.0f * implicit_pad(ray) + noise;
  r.error = pad + pad;
  vi unsure = live;
  for (uint i = 0; i < 8u; ++i) {
    const v3 front = along(r.p, r.n, r.error), back = along(r.p, r.n, -r.error);
    const ImplicitBounds f = implicit_bounds(formula, between(front.x, front.x, pad), between(front.y, front.y, pad),
                                             between(front.z, front.z, pad), ray.d);
    const ImplicitBounds g = implicit_bounds(formula, between(back.x, back.x, pad), between(back.y, back.y, pad),
                                             between(back.z, back.z, pad), ray.d);
    unsure = unsure & (((f.value.lo <= 0.0f) & (f.value.hi >= 0.0f)) | ((g.value.lo <= 0.0f) & (g.value.hi >= 0.0f)));
    if (!ANY(unsure)) break;
    r.error = unsure ? r.error + r.error : r.error;
  }
  return r;
}

#ifndef EK_FORMULA_COUNT  // where only the text is checked, and no formula is at hand
#define EK_FORMULA_COUNT 1
EK_FN vf implicit_value(uint formula, v3 p) { return dot3(p, p) - 1.0f; }
EK_FN v3 implicit_gradient(uint formula, v3 p) { return scale3(p, (vf)(2.0f)); }
EK_FN ImplicitBounds implicit_bounds(uint formula, Interval x, Interval y, Interval z, v3 d) {
  ImplicitBounds r = {interval_power(x, 2u), interval_mul(x, interval_point(d.x)), y.lo > z.hi};
  return r;
}
#endif

#endif
