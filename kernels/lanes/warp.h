// SPDX-License-Identifier: Apache-2.0
// Maps from the unit square, one to one and of constant Jacobian in their measure, so that strata
// of the square stay strata. Each takes u and v in [0, 1 - 2^-24], ends included, and has a
// positive density there.
#ifndef EK_WARP_H
#define EK_WARP_H
#include "lanes/math.h"

#define EK_INV_2PI 0.159154943091895f  // pdf_sr of warp_uniform_hemisphere
#define EK_INV_4PI 0.0795774715459477f  // pdf_sr of warp_uniform_sphere
// pdf_sr of warp_cosine_hemisphere: z * EK_INV_PI

typedef struct { vf x, y, r; } DiskPoint;  // r: its distance from the centre, < 1

// The concentric map [Shirley and Chiu 1997]: squares about the centre become circles, so cells
// stay compact.
EK_FN DiskPoint warp_disk(vf u, vf v) {
  // The middle of the sampler's cell of side 2^-24: exact, in (-1, 1), and never on the rim, where
  // densities vanish.
  const vf a = 2.0f * u - (1.0f - 0x1p-24f);
  const vf b = 2.0f * v - (1.0f - 0x1p-24f);
  const vi wide = abs_f(a) > abs_f(b);
  const vf radius = wide ? a : b;
  vf turn = div_f(0.125f * (wide ? b : a), radius);
  turn = radius == 0.0f ? (vf)(0.0f) : turn;
  vf s, c;
  sincos_2pi_octant(turn, &s, &c);
  DiskPoint p = {radius * (wide ? c : s), radius * (wide ? s : c), abs_f(radius)};
  return p;
}

/// Directions about +z with pdf_sr = z / pi [Malley's method].
EK_FN v3 warp_cosine_hemisphere(vf u, vf v) {
  const DiskPoint p = warp_disk(u, v);
  return V3(p.x, p.y, sqrt_f((1.0f - p.r) * (1.0f + p.r)));
}

/// Directions about +z with pdf_sr = 1 / (2 pi).
EK_FN v3 warp_uniform_hemisphere(vf u, vf v) {
  const DiskPoint p = warp_disk(u, v);
  const vf r2 = p.r * p.r;
  const vf stretch = sqrt_f(2.0f - r2);
  return V3(p.x * stretch, p.y * stretch, (1.0f - p.r) * (1.0f + p.r));
}

/// Directions with pdf_sr = 1 / (4 pi).
EK_FN v3 warp_uniform_sphere(vf u, vf v) {
  const DiskPoint p = warp_disk(u, v);
  const vf r2 = p.r * p.r;
  const vf stretch = 2.0f * sqrt_f((1.0f - p.r) * (1.0f + p.r));
  return V3(p.x * stretch, p.y * stretch, 1.0f - 2.0f * r2);
}

/// Directions within a cone about +z with pdf_sr = 1 / (2 pi omc).
/// omc  1 less the cosine of the cone's half angle, in (0, 2]; 2 is the whole sphere
EK_FN v3 warp_cone(vf u, vf v, vf omc) {
  const DiskPoint p = warp_disk(u, v);
  const vf below = (p.r * p.r) * omc;  // 1 less the cosine of the direction
  const vf stretch = sqrt_f(omc * (2.0f - below));
  return V3(p.x * stretch, p.y * stretch, 1.0f - below);
}

/// Weights of a triangle's second and third corner, uniform over its area; the first has 1 - b1 -
/// b2 >= 0.
/// source  [Heitz 2019, "A Low-Distortion Map Between Triangle and Square"]
EK_FN void warp_triangle(vf u, vf v, vf* b1, vf* b2) {
  const vi above = v > u;
  const vf half_lesser = 0.5f * (above ? u : v);
  *b1 = above ? half_lesser : u - half_lesser;
  *b2 = above ? v - half_lesser : half_lesser;
}

#endif
