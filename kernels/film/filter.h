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
  const vi root = TO_I(sqrt(place));
  const vi bin = root < EK_FILTER_BINS - 1 ? root : (vi)(EK_FILTER_BINS - 1);
  const vf m = TO_F(bin);
  const vf outer = gather_f(filter_table, AS_U(bin)), inner = gather_f(filter_table, AS_U(bin) + 1u);
  const vf distance = outer + (inner - outer) * ((place - m * m) / (2.0f * m + 1.0f));
  const float factor = filter_table[EK_FILTER_BINS + 2];
  FilterSample s = {right ? distance : -distance,
                    distance > filter_table[EK_FILTER_BINS + 1] ? (vf)(-factor) : (vf)(factor)};
  return s;
}

#endif
