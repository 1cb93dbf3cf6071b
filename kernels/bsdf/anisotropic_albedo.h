// SPDX-License-Identifier: Apache-2.0
// Directional albedo of anisotropic GGX microfacets, interpolated in a table
// (tools/tables/make_anisotropy_table.py explains it): never less than the truth, and for a
// dielectric of reflectance 0.04 on average 0.04 more.
#ifndef EK_ANISOTROPIC_ALBEDO_H
#define EK_ANISOTROPIC_ALBEDO_H
#include "bsdf/tables/anisotropy_table.h"
#include "bsdf/ggx_albedo.h"
#include "bsdf/microfacet.h"

// A position among evenly spaced values: the index below it, and the weight of the value above.
typedef struct { vu low; vf weight; } TablePlace;

/// x  [0, 1]
EK_FN TablePlace table_place(vf x, uint count) {
  const vf place = min_f(max_f(x, (vf)(0.0f)), (vf)(1.0f)) * (float)(count - 1u);
  const vi low = TO_I(min_f(place, (vf)((float)(count - 2u))));
  const TablePlace at = {AS_U(low), place - TO_F(low)};
  return at;
}

EK_FN vf mix_f(vf a, vf b, vf weight) { return a + (b - a) * weight; }

// Both albedos of entry i of a table.
EK_FN GgxAlbedo load_albedo(constant const float* table, vu i) {
  const GgxAlbedo a = {table_f(table, i * 2u), table_f(table, i * 2u + 1u)};
  return a;
}
EK_FN GgxAlbedo mix_albedo(GgxAlbedo a, GgxAlbedo b, vf weight) {
  const GgxAlbedo mixed = {mix_f(a.full, b.full, weight), mix_f(a.grazing, b.grazing, weight)};
  return mixed;
}
EK_FN GgxAlbedo albedo_between(constant const float* table, vu i, vu next, vf weight) {
  return mix_albedo(load_albedo(table, i), load_albedo(table, i + next), weight);
}

/// c, length  cosine, (0, 1], and ggx_length of the direction
EK_FN GgxAlbedo anisotropic_albedo(GgxAlpha alpha, vf c, vf length) {
  // The table's coordinates p and q have length^2 = p^2 sin^2 + c^2 and p^2 + q^2 = x^2 + y^2.
  const vf x2 = alpha.x * alpha.x, y2 = alpha.y * alpha.y;
  const vf sin2 = max_f((1.0f - c) * (1.0f + c), (vf)(0x1p-20f));
  const vf p2 = min_f(max_f(div_f((length - c) * (length + c), sin2), min_f(x2, y2)), max_f(x2, y2)), q2 = (x2 + y2) - p2;
  const TablePlace p = table_place(sqrt_f(sqrt_f(p2)), EK_ANISOTROPY_ROWS), q = table_place(sqrt_f(sqrt_f(q2)), EK_ANISOTROPY_ROWS),
                   column = table_place(sqrt_f(max_f(c, (vf)(0.0f))), EK_ANISOTROPY_COLUMNS);
  const uint row = EK_ANISOTROPY_COLUMNS, block = EK_ANISOTROPY_ROWS * EK_ANISOTROPY_COLUMNS;
  const vu i = (p.low * EK_ANISOTROPY_ROWS + q.low) * row + column.low;
  constant const float* table = anisotropy_albedo_table;
  const vu one = (vu)(1u);
  const GgxAlbedo here = mix_albedo(albedo_between(table, i, one, column.weight),
                                    albedo_between(table, i + row, one, column.weight), q.weight);
  const GgxAlbedo next = mix_albedo(albedo_between(table, i + block, one, column.weight),
                                    albedo_between(table, i + (block + row), one, column.weight), q.weight);
  const GgxAlbedo all = mix_albedo(here, next, p.weight);
  const vf rho2 = max_f(1.0f - div_f(x2 * y2, p2 * q2), (vf)(0.0f));
  const vf g = max_f(1.0f - c, (vf)(0.0f)), g2 = g * g, g8 = (g2 * g2) * (g2 * g2);
  GgxAlbedo a;
  a.full = all.full + (EK_ANISOTROPY_LIFT_FULL + (EK_ANISOTROPY_SHARP_FULL * g8 + EK_ANISOTROPY_SKEW_FULL * (rho2 * g)));
  a.grazing = all.grazing + (EK_ANISOTROPY_LIFT_GRAZING + (EK_ANISOTROPY_SHARP_GRAZING * g8 +
                                                           EK_ANISOTROPY_SKEW_GRAZING * ((rho2 * rho2) * g2)));
  a.full = min_f(a.full, (vf)(1.0f));
  a.grazing = min_f(a.grazing, (vf)(1.0f));
  return a;
}

/// 2 times the integral over the cosine of the albedo times the cosine; at most that of
/// anisotropic_albedo.
EK_FN GgxAlbedo anisotropic_mean_albedo(GgxAlpha alpha) {
  const TablePlace x = table_place(sqrt_f(alpha.x), EK_ANISOTROPY_ROWS), y = table_place(sqrt_f(alpha.y), EK_ANISOTROPY_ROWS);
  const vu i = x.low * EK_ANISOTROPY_ROWS + y.low, next = (vu)(EK_ANISOTROPY_ROWS);
  return mix_albedo(albedo_between(anisotropy_mean_table, i, (vu)(1u), y.weight),
                    albedo_between(anisotropy_mean_table, i + next, (vu)(1u), y.weight), x.weight);
}

#endif
