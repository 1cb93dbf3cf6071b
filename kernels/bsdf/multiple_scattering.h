// SPDX-License-Identifier: Apache-2.0
// --energy-compensation: light that GGX microfacets lose because it meets a second one leaves as from a diffuse surface whose
// lobe is what either direction loses [Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks"]:
//   f = F lost(wo) lost(wi) / (pi lost_mean)
// with lost(w) = 1 - albedo of microfacets that reflect everything, and F what is left of light after some more reflections:
// reciprocal, and exactly as much as the table says is lost. Metal of two alphas has the tables of layers, which say at most 0.11 too
// little is lost, 0.03 in the mean; glass of two alphas that of their geometric mean, which is a guess.
#ifndef EK_MULTIPLE_SCATTERING_H
#define EK_MULTIPLE_SCATTERING_H
#include "bsdf/anisotropic_albedo.h"
#include "bsdf/tables/energy_table.h"
#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

// Of one alpha: along a direction of cosine c, and 2 times the integral over c of that times c.
EK_FN vf isotropic_lose(vf alpha, vf c) {
  const TablePlace row = table_place(sqrt(alpha), EK_ENERGY_ROWS), column = table_place(sqrt(max_f(c, (vf)(0.0f))), EK_ENERGY_COLUMNS);
  constant const float* table = energy_lost_table;
  const vu i = row.low * EK_ENERGY_COLUMNS + column.low;
  const vf here = mix_f(table_f(table, i), table_f(table, i + 1u), column.weight),
           next = mix_f(table_f(table, i + EK_ENERGY_COLUMNS), table_f(table, i + (EK_ENERGY_COLUMNS + 1u)), column.weight);
  return mix_f(here, next, row.weight);
}
EK_FN vf isotropic_lose_mean(vf alpha) {
  const TablePlace row = table_place(sqrt(alpha), EK_ENERGY_ROWS);
  return mix_f(table_f(energy_lost_mean_table, row.low), table_f(energy_lost_mean_table, row.low + 1u), row.weight);
}

/// The share that microfacets which reflect everything lose of light along a direction of cosine c; length: its ggx_length
EK_FN vf mirrors_lose(GgxAlpha alpha, vf c, vf length) {
  const vf lost = isotropic_lose(alpha.y, c);
  if (!EK_HAS_anisotropy) return lost;
  const vi differs = alpha.x != alpha.y;
  return ANY(differs) ? (differs ? 1.0f - anisotropic_albedo(alpha, c, length).full : lost) : lost;
}

/// 2 times the integral over c of mirrors_lose times c.
EK_FN vf mirrors_lose_mean(GgxAlpha alpha) {
  const vf lost = isotropic_lose_mean(alpha.y);
  if (!EK_HAS_anisotropy) return lost;
  const vi differs = alpha.x != alpha.y;
  return ANY(differs) ? (differs ? 1.0f - anisotropic_mean_albedo(alpha).full : lost) : lost;
}

/// What leaves of light that microfacets of mean reflectance f lose to each other, if they lose `lost` of all light at a time
/// [Kulla and Conty 2017, "Fresnel"]; 1 for f = 1, whatever is lost.
EK_FN vf reflected_again(vf f, vf lost) { return (f * f) * (1.0f - lost) / max_f(1.0f - f * lost, (vf)(0x1p-20f)); }
EK_FN v3 reflected_again3(v3 f, vf lost) {
  return V3(reflected_again(f.x, lost), reflected_again(f.y, lost), reflected_again(f.z, lost));
}

// A dielectric's table: which layers, for light on either side.
typedef struct {
  TablePlace layer;
  vu here, there;  // where the tables of wo's side and of the other side begin, in layers
} GlassPlace;

/// eta: index of the far side over that of wo's; beyond the tables' range the nearest of theirs
EK_FN GlassPlace glass_place(vf eta) {
  const vf root = abs_f(eta - 1.0f) / (eta + 1.0f);
  GlassPlace at;
  at.layer = table_place((root - EK_ENERGY_GLASS_FIRST) * (1.0f / (EK_ENERGY_GLASS_LAST - EK_ENERGY_GLASS_FIRST)), EK_ENERGY_GLASS_LAYERS);
  const vi outside = eta > 1.0f;
  at.here = outside ? (vu)(0u) : (vu)(EK_ENERGY_GLASS_LAYERS);
  at.there = outside ? (vu)(EK_ENERGY_GLASS_LAYERS) : (vu)(0u);
  return at;
}

/// side: at.here or at.there
EK_FN vf glass_loses(GlassPlace at, vu side, vf alpha, vf c) {
  const TablePlace row = table_place(sqrt(alpha), EK_ENERGY_GLASS_ROWS),
                   column = table_place(sqrt(max_f(c, (vf)(0.0f))), EK_ENERGY_GLASS_COLUMNS);
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

/// 2 times the integral over c of glass_loses times c.
EK_FN vf glass_loses_mean(GlassPlace at, vu side, vf alpha) {
  const TablePlace row = table_place(sqrt(alpha), EK_ENERGY_GLASS_ROWS);
  constant const float* table = energy_glass_mean_table;
  const vu i = (side + at.layer.low) * EK_ENERGY_GLASS_ROWS + row.low;
  const vf here = mix_f(table_f(table, i), table_f(table, i + 1u), row.weight),
           next = mix_f(table_f(table, i + EK_ENERGY_GLASS_ROWS), table_f(table, i + (EK_ENERGY_GLASS_ROWS + 1u)), row.weight);
  return mix_f(here, next, at.layer.weight);
}

/// The one alpha that stands for both.
EK_FN vf glass_alpha(GgxAlpha alpha) { return EK_HAS_anisotropy ? sqrt(alpha.x * alpha.y) : alpha.y; }

#endif
