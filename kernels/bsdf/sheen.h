// SPDX-License-Identifier: Apache-2.0
// Fibres that stand off a surface, as on velvet [KHR_materials_sheen]: the Charlie distribution of
// microfacets with fitted shadowing [Estevez and Kulla 2017, "Production Friendly Microfacet Sheen
// BRDF"]. Below a roughness of 0.25 the lobe would reflect more than it receives at grazing angles,
// so it is scaled down (tools/tables/make_sheen_table.py). Its cosines are clamped to 2^-10 at
// least.
#ifndef EK_BSDF_SHEEN_H
#define EK_BSDF_SHEEN_H
#include "bsdf/tables/sheen_table.h"
#include "lanes/warp.h"

// The terms that depend on the roughness alone.
typedef struct {
  vf alpha;
  vf scale;             // of the distribution
  vf a, b, c, d, e;     // of shadowing
  vf half_exponent;     // of shadowing at a cosine of 1/2
  vu row;               // of the table, and the weight of the next
  vf row_weight;
} Sheen;

// [Estevez and Kulla 2017, equation 3]; cosine in [2^-10, 1/2]
EK_FN vf sheen_shadowing_exponent(Sheen k, vf cosine) {
  return div_f(k.a, 1.0f + k.b * exp2_f(k.c * log2_f(cosine))) + (k.d * cosine + k.e);
}

/// roughness  [0, 1], as glTF has it
EK_FN Sheen make_sheen(vf roughness) {
  Sheen k;
  const vf r = max_f(roughness, (vf)(EK_SHEEN_LEAST_ROUGHNESS));
  k.alpha = r * r;
  const vf t = (1.0f - k.alpha) * (1.0f - k.alpha), s = 1.0f - t;
  k.a = t * 25.3245f + s * 21.5473f;
  k.b = t * 3.32435f + s * 3.82987f;
  k.c = t * 0.16801f + s * 0.19823f;
  k.d = t * -1.27393f + s * -1.97760f;
  k.e = t * -4.85967f + s * -4.32054f;
  k.half_exponent = sheen_shadowing_exponent(k, (vf)(0.5f));
  const vf place = (r - EK_SHEEN_LEAST_ROUGHNESS) * ((EK_SHEEN_ROWS - 1u) / (1.0f - EK_SHEEN_LEAST_ROUGHNESS));
  const vi row = TO_I(min_f(place, (vf)(EK_SHEEN_ROWS - 2u)));
  k.row = AS_U(row);
  k.row_weight = place - TO_F(row);
  const vf here = table_f(sheen_shrink_table, k.row), next = table_f(sheen_shrink_table, k.row + 1u);
  k.scale = (here + (next - here) * k.row_weight) * ((2.0f + div_f(1.0f, k.alpha)) * EK_INV_2PI);
  return k;
}

// Lambda; cosine in [2^-10, 1].
EK_FN vf sheen_shadowing(Sheen k, vf cosine) {
  const vi low = cosine < 0.5f;
  const vf x = sheen_shadowing_exponent(k, max_f(low ? cosine : 1.0f - cosine, (vf)(EK_SHEEN_LEAST_COSINE)));
  return exp2_f(1.44269504f * (low ? x : 2.0f * k.half_exponent - x));
}

/// f of a white lobe.
/// wo, wi  above the surface
EK_FN vf sheen_f(Sheen k, v3 wo, v3 wi) {
  const v3 sum = add3(wo, wi);
  const vf flat2 = sum.x * sum.x + sum.y * sum.y;
  const vf sin2 = div_f(flat2, max_f(flat2 + sum.z * sum.z, (vf)(0x1p-100f)));
  const vf d = k.scale * exp2_f(div_f(0.5f, k.alpha) * log2_f(sin2));
  const vf cos_o = max_f(wo.z, (vf)(EK_SHEEN_LEAST_COSINE)), cos_i = max_f(wi.z, (vf)(EK_SHEEN_LEAST_COSINE));
  return div_f(d, (4.0f * (cos_o * cos_i)) * (1.0f + (sheen_shadowing(k, cos_o) + sheen_shadowing(k, cos_i))));
}

/// Directional albedo of the white lobe, [0, 1]; never less than the truth, and at most 0.02 more.
EK_FN vf sheen_albedo(Sheen k, vf cosine) {
  const vf place = sqrt_f(max_f(cosine, (vf)(0.0f))) * (EK_SHEEN_COLUMNS - 1u);
  const vi column = TO_I(min_f(place, (vf)(EK_SHEEN_COLUMNS - 2u)));
  const vf weight = place - TO_F(column);
  const vu i = k.row * EK_SHEEN_COLUMNS + AS_U(column);
  const vf a = table_f(sheen_albedo_table, i), b = table_f(sheen_albedo_table, i + 1u),
           c = table_f(sheen_albedo_table, i + EK_SHEEN_COLUMNS),
           d = table_f(sheen_albedo_table, i + (EK_SHEEN_COLUMNS + 1u));
  const vf here = a + (b - a) * weight, next = c + (d - c) * weight;
  return min_f((here + (next - here) * k.row_weight) + EK_SHEEN_LIFT, (vf)(1.0f));
}

#endif
