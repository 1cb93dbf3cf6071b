// SPDX-License-Identifier: Apache-2.0
// Directional albedo of the GGX lobe, which has no closed form: fits by tools/tables/fit_albedo.py,
// which explains and checks them. They are never less than the truth, so that a layer and the base
// below never reflect more than 1; they are at most 5e-3 more for a dielectric of reflectance 0.04,
// and 0.022 more for microfacets that reflect everything. A mirror's albedo is exact.
#ifndef EK_GGX_ALBEDO_H
#define EK_GGX_ALBEDO_H
#include "lanes/math.h"
#include "bsdf/fresnel.h"

#define EK_ALBEDO_LOSS_0 -0.0127232233f
#define EK_ALBEDO_LOSS_1 0.0116079608f
#define EK_ALBEDO_LOSS_2 0.242245644f
#define EK_ALBEDO_LOSS_3 0.0316094719f
#define EK_ALBEDO_LOSS_4 2.68250799f
#define EK_ALBEDO_LOSS_5 -1.23957586f
#define EK_ALBEDO_LOSS_6 -2.26217413f
#define EK_ALBEDO_LOSS_7 1.0076499f
#define EK_ALBEDO_LOSS_8 -0.536902368f
#define EK_ALBEDO_LOSS_9 0.620980144f
#define EK_ALBEDO_LOSS_10 1.46563828f
#define EK_ALBEDO_LOSS_11 -1.38889873f
#define EK_ALBEDO_LOSS_12 -0.892397702f
#define EK_ALBEDO_COSINE_0 12.0841951f
#define EK_ALBEDO_COSINE_1 511.829407f
#define EK_ALBEDO_COSINE_2 -241.803284f
#define EK_ALBEDO_COSINE_3 15.7300129f
#define EK_ALBEDO_COSINE_4 -177.712433f
#define EK_ALBEDO_COSINE_5 124.15377f
#define EK_ALBEDO_COSINE_6 -86.8260803f
#define EK_ALBEDO_COSINE_7 -189.38765f
#define EK_ALBEDO_COSINE_8 -246.87851f
#define EK_ALBEDO_COSINE_9 35.6255836f
#define EK_ALBEDO_COSINE_10 117.676361f
#define EK_ALBEDO_COSINE_11 500.827881f
#define EK_ALBEDO_COSINE_12 0.978108466f
#define EK_ALBEDO_COSINE_13 -46.3397102f
#define EK_ALBEDO_COSINE_14 -415.442322f
#define EK_ALBEDO_MEAN_LOSS_0 -0.00159967608f
#define EK_ALBEDO_MEAN_LOSS_1 0.16592626f
#define EK_ALBEDO_MEAN_LOSS_2 -1.99744824f
#define EK_ALBEDO_MEAN_LOSS_3 8.49543353f
#define EK_ALBEDO_MEAN_LOSS_4 -12.0299657f
#define EK_ALBEDO_MEAN_LOSS_5 8.45743889f
#define EK_ALBEDO_MEAN_LOSS_6 -2.51196261f
#define EK_ALBEDO_MEAN_GRAZING_0 0.0484324329f
#define EK_ALBEDO_MEAN_GRAZING_1 0.0311372698f
#define EK_ALBEDO_MEAN_GRAZING_2 -0.243407032f
#define EK_ALBEDO_MEAN_GRAZING_3 -0.331457179f
#define EK_ALBEDO_MEAN_GRAZING_4 1.6832306f
#define EK_ALBEDO_MEAN_GRAZING_5 -1.82227201f
#define EK_ALBEDO_MEAN_GRAZING_6 0.63960397f
#define EK_ALBEDO_LIFT_FULL 0.0104f
#define EK_ALBEDO_LIFT_GRAZING 0.0019f

// `full`: microfacets reflect all light; `grazing`: they reflect (1 - cos)^5.
typedef struct { vf full, grazing; } GgxAlbedo;

/// Albedo of microfacets that reflect f0 + (f90 - f0) (1 - cos)^5, f0 <= f90; [0, 1].
EK_FN vf ggx_reflected(GgxAlbedo a, vf f0, vf f90) { return f0 * a.full + (f90 - f0) * a.grazing; }

// The fits at one alpha: rational functions of the direction.
typedef struct {
  vi mirror;
  vf loss_p, loss_p2, loss_q, loss_q2, loss_under, loss_under_q, loss_under_q2;
  vf cosine_1, cosine_q, cosine_c, cosine_c2, cosine_under, cosine_under_q;
  GgxAlbedo mean;  // 2 times the integral over c of albedo(c) c
} GgxAlbedoFit;

/// mirror  mask; alpha does not matter there
EK_FN GgxAlbedoFit ggx_albedo_fit(vi mirror, vf alpha) {
  const vf a = alpha, a2 = alpha * alpha, r = sqrt_f(alpha);
  GgxAlbedoFit k;
  k.mirror = mirror;
  k.loss_p = EK_ALBEDO_LOSS_0 + a * EK_ALBEDO_LOSS_1;
  k.loss_p2 = EK_ALBEDO_LOSS_2 + a * EK_ALBEDO_LOSS_3;
  k.loss_q = a2 * (EK_ALBEDO_LOSS_4 + a * EK_ALBEDO_LOSS_5);
  k.loss_q2 = a2 * (EK_ALBEDO_LOSS_6 + a * EK_ALBEDO_LOSS_7);
  k.loss_under = 1.0f + a * EK_ALBEDO_LOSS_8;
  k.loss_under_q = EK_ALBEDO_LOSS_9 + a * EK_ALBEDO_LOSS_10;
  k.loss_under_q2 = EK_ALBEDO_LOSS_11 + a * EK_ALBEDO_LOSS_12;
  k.cosine_1 = EK_ALBEDO_COSINE_0 + r * (EK_ALBEDO_COSINE_1 + r * EK_ALBEDO_COSINE_2);
  k.cosine_q = EK_ALBEDO_COSINE_3 + r * (EK_ALBEDO_COSINE_4 + r * EK_ALBEDO_COSINE_5);
  k.cosine_c = EK_ALBEDO_COSINE_6 + r * (EK_ALBEDO_COSINE_7 + r * EK_ALBEDO_COSINE_9);
  k.cosine_c2 = (vf)(EK_ALBEDO_COSINE_8);
  k.cosine_under = 1.0f + r * (EK_ALBEDO_COSINE_10 + r * EK_ALBEDO_COSINE_11);
  k.cosine_under_q = EK_ALBEDO_COSINE_12 + r * (EK_ALBEDO_COSINE_13 + r * EK_ALBEDO_COSINE_14);
  const vf mean_loss = EK_ALBEDO_MEAN_LOSS_0 + r * (EK_ALBEDO_MEAN_LOSS_1 + r * (EK_ALBEDO_MEAN_LOSS_2 + r * (
      EK_ALBEDO_MEAN_LOSS_3 + r * (EK_ALBEDO_MEAN_LOSS_4 + r * (EK_ALBEDO_MEAN_LOSS_5 + r * EK_ALBEDO_MEAN_LOSS_6)))));
  const vf mean_grazing = EK_ALBEDO_MEAN_GRAZING_0 + r * (EK_ALBEDO_MEAN_GRAZING_1 + r * (EK_ALBEDO_MEAN_GRAZING_2 + r * (
      EK_ALBEDO_MEAN_GRAZING_3 + r * (EK_ALBEDO_MEAN_GRAZING_4 + r * (EK_ALBEDO_MEAN_GRAZING_5 + r * EK_ALBEDO_MEAN_GRAZING_6)))));
  k.mean.full = mirror ? (vf)(1.0f) : 1.0f - mean_loss;
  k.mean.grazing = mirror ? (vf)(1.0f / 21.0f) : mean_grazing;
  return k;
}

/// c, length  cosine and ggx_length of the direction
EK_FN GgxAlbedo ggx_albedo(GgxAlbedoFit k, vf c, vf length) {
  const vf q = div_f(c, length);
  const vf p = sqrt_f(max_f((1.0f - q) * (1.0f + q), (vf)(0.0f)));
  const vf loss = div_f(q * (p * (k.loss_p + p * k.loss_p2) + (k.loss_q + q * k.loss_q2)), k.loss_under + q * (k.loss_under_q + q * k.loss_under_q2));
  const vf cosine = c + div_f((length - c) * ((k.cosine_1 + q * k.cosine_q) + c * (k.cosine_c + c * k.cosine_c2)), k.cosine_under + q * k.cosine_under_q);
  const vf kept = 1.0f - loss;
  const vf weight = schlick_weight(k.mirror ? c : cosine);
  GgxAlbedo a;
  a.full = k.mirror ? (vf)(1.0f) : min_f(kept + EK_ALBEDO_LIFT_FULL, (vf)(1.0f));
  a.grazing = k.mirror ? weight : min_f(kept * weight + EK_ALBEDO_LIFT_GRAZING, (vf)(1.0f));
  return a;
}

#endif
