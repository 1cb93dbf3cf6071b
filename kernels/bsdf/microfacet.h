// SPDX-License-Identifier: Apache-2.0
// The GGX distribution of microfacets, its shadowing, and its visible normals. alpha is glTF's
// roughness squared, along x and y. Directions w have w.z > 0. Everything is written in
//   L(w) = sqrt((alpha.x w.x)^2 + (alpha.y w.y)^2 + w.z^2) = w.z (1 + 2 Lambda(w))
// (ggx_length) [Heitz 2014, eq. 72], which needs no tangents and no differences of large numbers,
// from the pole to the horizon.
#ifndef EK_MICROFACET_H
#define EK_MICROFACET_H
#include "lanes/math.h"

// Below this alpha a surface counts as a perfect mirror: at 2^-13 the lobe is 0.014 degrees wide,
// and float directions resolve 2^-23.
#define EK_SMOOTH_ALPHA 0x1p-13f

typedef struct { vf x, y; } GgxAlpha;

EK_FN GgxAlpha ggx_isotropic(vf alpha) {
  GgxAlpha a = {alpha, alpha};
  return a;
}

EK_FN vf ggx_length(v3 w, GgxAlpha alpha) {
  if (EK_HAS_anisotropy) {
    const vf x = alpha.x * w.x, y = alpha.y * w.y;
    return sqrt_f((x * x + y * y) + w.z * w.z);
  }
  return sqrt_f((alpha.x * alpha.x) * (w.x * w.x + w.y * w.y) + w.z * w.z);
}

/// Density of microfacet normals per area and sr [Trowbridge and Reitz 1975; Walter et al. 2007,
/// eq. 33].
/// h  unit, h.z >= 0
EK_FN vf ggx_d(v3 h, GgxAlpha alpha) {
  const vf x = div_f(h.x, alpha.x), y = div_f(h.y, alpha.y);
  const vf q = (x * x + y * y) + h.z * h.z;
  return div_f(div_f(EK_INV_PI, alpha.x * alpha.y), q * q);
}

/// G2 / (4 cos_o cos_i) cos_i, with height-correlated shadowing and masking [Heitz 2014, eq. 99];
/// at most 1 / (2 length_o).
EK_FN vf ggx_visibility(vf cos_o, vf length_o, vf cos_i, vf length_i) {
  return 0.5f * div_f(cos_i, cos_o * length_i + cos_i * length_o);
}

/// G1 / (2 cos_o): times D(h) / 2 it is the density of the reflection of wo about a visible normal
/// h [Heitz 2018, eq. 17].
EK_FN vf ggx_visible_share(vf cos_o, vf length_o) { return div_f(1.0f, cos_o + length_o); }

/// Samples a visible normal, not unit, with density G1(wo) max(0, dot(wo, h)) D(h) / cos_o [Dupuy
/// and Benyoub 2023, listing 3: the reflection of a spherical cap].
/// u, v  [0, 1)^2
EK_FN v3 ggx_visible_normal(v3 wo, GgxAlpha alpha, vf u, vf v) {
  const v3 w = normalize3(V3(alpha.x * wo.x, alpha.y * wo.y, wo.z));
  // The normal is the sum of w and a point of the cap z > -w.z; 1 - z and 1 + z are computed
  // without differences of nearly equal numbers.
  const vf above = 1.0f + w.z;
  const vf below = div_f(w.x * w.x + w.y * w.y, above);  // 1 - w.z
  const vf z_sum = (1.0f - v) * above;
  const vf r = sqrt_f((v * above) * (below + z_sum));
  vf s, c;
  sincos_2pi(u, &s, &c);
  return V3(alpha.x * (r * c + w.x), alpha.y * (r * s + w.y), z_sum);
}

/// wo mirrored about n, which need not be unit.
EK_FN v3 mirrored(v3 wo, v3 n) { return sub3(scale3(n, div_f(2.0f * dot3(wo, n), dot3(n, n))), wo); }

/// The unit vector along s; +z where s vanishes.
EK_FN v3 direction_of(v3 s, vf length2) {
  const vi usable = length2 > 0x1p-100f;
  const vf inverse = div_f(1.0f, sqrt_f(usable ? length2 : (vf)(1.0f)));
  return select3(usable, scale3(s, inverse), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)));
}

#endif
