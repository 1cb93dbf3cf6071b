// SPDX-License-Identifier: Apache-2.0
// --energy-compensation: the light that GGX microfacets reflect to each other, which single
// scattering loses, leaves in a diffuse lobe [Kulla and Conty 2017, "Revisiting Physically Based
// Shading at Imageworks"]:
//   f = F_ms (1 - E(wo)) (1 - E(wi)) / (pi (1 - E_avg))
// with E the directional albedo of microfacets that reflect all light, E_avg its cosine-weighted
// mean, and F_ms the colour that more reflections leave. The lobe is reciprocal, and has exactly
// the energy that the table says is lost. Anisotropic metal uses the albedo tables of specular
// layers, which give at most 0.11 too little, 0.03 on average. Anisotropic glass uses the
// tables of isotropic glass that loses as much.
#ifndef EK_MULTIPLE_SCATTERING_H
#define EK_MULTIPLE_SCATTERING_H
#include "bsdf/anisotropic_albedo.h"
#include "bsdf/tables/energy_table.h"
#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

// 1 - E of isotropic microfacets for a direction of cosine c, and its cosine-weighted mean.
EK_FN vf isotropic_one_minus_E(vf alpha, vf c) {
  const TablePlace row = table_place(sqrt_f(alpha), EK_ENERGY_ROWS), column = table_place(sqrt_f(max_f(c, (vf)(0.0f))), EK_ENERGY_COLUMNS);
  constant const float* table = energy_lost_table;
  const vu i = row.low * EK_ENERGY_COLUMNS + column.low;
  const vf here = mix_f(table_f(table, i), table_f(table, i + 1u), column.weight),
           next = mix_f(table_f(table, i + EK_ENERGY_COLUMNS), table_f(table, i + (EK_ENERGY_COLUMNS + 1u)), column.weight);
  return mix_f(here, next, row.weight);
}
EK_FN vf isotropic_one_minus_E_avg(vf alpha) {
  const TablePlace row = table_place(sqrt_f(alpha), EK_ENERGY_ROWS);
  return mix_f(table_f(energy_lost_mean_table, row.low), table_f(energy_lost_mean_table, row.low + 1u), row.weight);
}

/// 1 - E, with E the albedo of microfacets that reflect all light.
/// c, length  cosine and ggx_length of the direction
EK_FN vf one_minus_E(GgxAlpha alpha, vf c, vf length) {
  const vf isotropic = isotropic_one_minus_E(alpha.y, c);
  if (!EK_HAS_anisotropy) return isotropic;
  const vi differs = alpha.x != alpha.y;
  return ANY(differs) ? (differs ? 1.0f - anisotropic_albedo(alpha, c, length).full : isotropic) : isotropic;
}

/// 1 - E_avg: 2 times the integral over c of one_minus_E times c.
EK_FN vf one_minus_E_avg(GgxAlpha alpha) {
  const vf isotropic = isotropic_one_minus_E_avg(alpha.y);
  if (!EK_HAS_anisotropy) return isotropic;
  const vi differs = alpha.x != alpha.y;
  return ANY(differs) ? (differs ? 1.0f - anisotropic_mean_albedo(alpha).full : isotropic) : isotropic;
}

/// F_ms of microfacets of mean reflectance f [Kulla and Conty 2017, "Fresnel"], 1 for f = 1.
/// one_minus_avg  1 - E_avg, the share of light that single scattering loses
EK_FN vf ms_fresnel(vf f, vf one_minus_avg) {
  return div_f((f * f) * (1.0f - one_minus_avg), max_f(1.0f - f * one_minus_avg, (vf)(0x1p-20f)));
}
EK_FN v3 ms_fresnel3(v3 f, vf one_minus_avg) {
  return V3(ms_fresnel(f.x, one_minus_avg), ms_fresnel(f.y, one_minus_avg), ms_fresnel(f.z, one_minus_avg));
}

// The layers of the glass tables that an index of refraction falls between.
typedef struct {
  TablePlace layer;
  vu here, there;  // first layer of the tables of wo's side and of the other side
} GlassTable;

/// eta  index of the far side over that of wo's side, clamped to the range of the tables
EK_FN GlassTable glass_table(vf eta) {
  const vf root = div_f(abs_f(eta - 1.0f), eta + 1.0f);
  GlassTable at;
  at.layer = table_place((root - EK_ENERGY_GLASS_FIRST) * (1.0f / (EK_ENERGY_GLASS_LAST - EK_ENERGY_GLASS_FIRST)), EK_ENERGY_GLASS_LAYERS);
  const vi outside = eta > 1.0f;
  at.here = outside ? (vu)(0u) : (vu)(EK_ENERGY_GLASS_LAYERS);
  at.there = outside ? (vu)(EK_ENERGY_GLASS_LAYERS) : (vu)(0u);
  return at;
}

/// 1 - E of a solid's interface.
/// side  at.here or at.there
EK_FN vf glass_one_minus_E(GlassTable at, vu side, vf alpha, vf c) {
  const TablePlace row = table_place(sqrt_f(alpha), EK_ENERGY_GLASS_ROWS),
                   column = table_place(sqrt_f(max_f(c, (vf)(0.0f))), EK_ENERGY_GLASS_COLUMNS);
  constant const float* table = energy_glass_table;
  const uint down = EK_ENERGY_GLASS_COLUMNS, deep = EK_ENERGY_GLASS_ROWS * EK_ENERGY_GLASS_COLUMNS;
  const vu i = (side + at.layer.low) * deep + row.low * down + column.low;
  vf two[2];
  for (uint k = 0; k < 2; ++k) {
    const vu j = i + k * deep;
    const vf here = mix_f(table_f(table, j), table_f(table, j + 1u), column.weight),
             next = mix_f(table_f(table, j + down), table_f(table, j + (down + 1u)), column.weight);
    two[k] = mix_f(here, next, row.weight);
  }
  return mix_f(two[0], two[1], at.layer.weight);
}

/// 1 - E_avg: 2 times the integral over c of glass_one_minus_E times c.
EK_FN vf glass_one_minus_E_avg(GlassTable at, vu side, vf alpha) {
  const TablePlace row = table_place(sqrt_f(alpha), EK_ENERGY_GLASS_ROWS);
  constant const float* table = energy_glass_mean_table;
  const vu i = (side + at.layer.low) * EK_ENERGY_GLASS_ROWS + row.low;
  const vf here = mix_f(table_f(table, i), table_f(table, i + 1u), row.weight),
           next = mix_f(table_f(table, i + EK_ENERGY_GLASS_ROWS), table_f(table, i + (EK_ENERGY_GLASS_ROWS + 1u)), row.weight);
  return mix_f(here, next, at.layer.weight);
}

/// The isotropic alpha whose glass loses as much light as this one does: about the middle between
/// the mean of both alphas and the root of their mean square. It was found in white furnaces of
/// spheres, where with strengths of .3 to 1 it is within 13 % of the right one; the geometric mean
/// was a tenth to two thirds of it.
EK_FN vf glass_alpha(GgxAlpha alpha) {
  if (!EK_HAS_anisotropy) return alpha.y;
  return 0.25f * (alpha.x + alpha.y) + 0.5f * sqrt_f(0.5f * (alpha.x * alpha.x + alpha.y * alpha.y));
}

#endif
