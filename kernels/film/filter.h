// SPDX-License-Identifier: Apache-2.0
// Places of samples on the film, drawn from a separable pixel filter (host/film/pixel_filter.h).
// filter_table holds the inverse of the distribution of |f| on one side: entry m is the distance
// from the pixel's middle beyond which lies the share (m / EK_FILTER_BINS)^2 of that side; between
// entries the density is constant. Shares are squares so that the thin rims of filters get bins as
// fine as the middle. Two more entries follow: the distance beyond which f is negative, and the
// factor that makes the mean weight 1.
#ifndef EK_FILTER_H
#define EK_FILTER_H
#include "lanes/math.h"

typedef struct {
  vf offset;  // pixels, from the pixel's middle
  vf weight;  // f over its density
} FilterSample;

/// Place along one axis, monotone in u.
/// u  [0, 1 - 2^-24], a multiple of 2^-24: up to the square root every step is exact
EK_FN FilterSample filter_sample(global const float* filter_table, vf u) {
  const vi right = u >= 0.5f;
  const vf from_rim = right ? 1.0f - u : u;  // of both sides together: (0, 1/2]
  const vf place = from_rim * (float)(2 * EK_FILTER_BINS * EK_FILTER_BINS);  // in [0, bins^2]
  const vi root = TO_I(sqrt_f(place));
  const vi bin = root < EK_FILTER_BINS - 1 ? root : (vi)(EK_FILTER_BINS - 1);
  const vf m = TO_F(bin);
  const vf outer = gather_f(filter_table, AS_U(bin)), inner = gather_f(filter_table, AS_U(bin) + 1u);
  const vf distance = outer + (inner - outer) * div_f(place - m * m, 2.0f * m + 1.0f);
  const float factor = filter_table[EK_FILTER_BINS + 2];
  FilterSample s = {right ? distance : -distance,
                    distance > filter_table[EK_FILTER_BINS + 1] ? (vf)(-factor) : (vf)(factor)};
  return s;
}

/// The filter at a distance from a pixel's middle, of integral 1: the density with which
/// filter_sample places samples, times their weight.
EK_FN vf filter_value(global const float* filter_table, vf offset) {
  const vf distance = abs_f(offset);
  vu bin = (vu)(0u);  // the last one whose outer end is not nearer
  for (uint step = EK_FILTER_BINS / 2; step != 0u; step /= 2u) {
    const vu next = bin + step;
    bin = gather_f(filter_table, next) > distance ? next : bin;
  }
  const vf outer = gather_f(filter_table, bin), inner = gather_f(filter_table, bin + 1u);
  const float share = 0.5f / (float)(EK_FILTER_BINS * EK_FILTER_BINS);
  const vf density = div_f((2.0f * TO_F(AS_I(bin)) + 1.0f) * share, outer - inner);
  const float factor = filter_table[EK_FILTER_BINS + 2];
  const vf value = distance > filter_table[EK_FILTER_BINS + 1] ? density * -factor : density * factor;
  return ((distance < filter_table[0]) & (outer > inner)) ? value : (vf)(0.0f);
}

/// Chooses one of the pixels along an axis whose filter reaches a place on the film, in proportion
/// to its magnitude there. pixel: is set to it; u: [0, 1). returns the filter over the probability
/// of that choice
EK_FN vf filter_pixel(global const float* filter_table, vf place, vf u, vf* pixel) {
  const float radius = filter_table[0];
  const int count = (int)(2.0f * radius) + 2;  // pixels that may be reached
  const vf first = place - (radius + 0.5f);
  const vf begin = TO_F(TO_I(first + 65536.0f)) - 65536.0f;  // rounded down; what rounding leaves out lies on the rim
  vf sum = (vf)(0.0f);
  for (int i = 0; i < count; ++i) sum = sum + abs_f(filter_value(filter_table, place - (begin + ((float)i + 0.5f))));
  const vf chosen = u * sum;
  vf before = (vf)(0.0f), weight = (vf)(0.0f);
  *pixel = begin;
  for (int i = 0; i < count; ++i) {
    const vf value = filter_value(filter_table, place - (begin + ((float)i + 0.5f)));
    const vi takes = (before <= chosen) & (value != 0.0f);  // the last one that does is the chosen one
    *pixel = takes ? begin + (float)i : *pixel;
    weight = takes ? copysign_f(sum, value) : weight;
    before = before + abs_f(value);
  }
  return weight;
}

#endif
