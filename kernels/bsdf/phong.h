// SPDX-License-Identifier: Apache-2.0
// Blinn's highlights over Lambert's base (EIKON_materials_phong) [Blinn 1977]:
//   f = base (1 - max(specular)) / pi + specular N cos(theta_h)^n,
//   N = (n + 2)(n + 4) / (8 pi (2^(-n/2) + n))
// N makes a white highlight reflect all light at normal incidence, where it reflects most [Giesen
// 2009, "Phong and Blinn-Phong normalization factors"]. The base is reduced by as much as the
// highlight can reflect, so no more light leaves than arrives. The lobe is reciprocal.
#ifndef EK_BSDF_PHONG_H
#define EK_BSDF_PHONG_H
#include "bsdf/lobe.h"
#include "bsdf/microfacet.h"
#include "bsdf/terminator.h"
#include "lanes/warp.h"

typedef struct {
  v3 base;         // f of the base
  vf scale;        // N
  vf p_highlight;  // probability of choosing the highlight
  vi any;          // the material reflects some light
} Phong;

EK_FN Phong make_phong(MaterialLanes m) {
  Phong k;
  const vf n = m.own.phong_shininess;
  const vf most = max_component(m.own.phong_specular);
  k.base = scale3(m.base_color, (1.0f - most) * EK_INV_PI);
  k.scale = div_f(((n + 2.0f) * (n + 4.0f)) * (0.125f * EK_INV_PI), exp2_f(-0.5f * n) + n);
  const vf highlight = mean_component(m.own.phong_specular), diffuse = (1.0f - most) * mean_component(m.base_color);
  k.any = highlight + diffuse > 0.0f;
  k.p_highlight = k.any ? div_f(highlight, highlight + diffuse) : (vf)(0.0f);
  return k;
}

EK_FN BsdfValue phong_value(MaterialLanes m, Phong k, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f) & k.any;
  const v3 sum = add3(wo, wi);
  const vf flat2 = sum.x * sum.x + sum.y * sum.y, z2 = max_f(sum.z * sum.z, (vf)(0x1p-100f));
  // cos^n is computed from the tangent, which keeps all its digits where it is small.
  const vf power = exp2_f((-0.5f * m.own.phong_shininess) * log2_f(1.0f + div_f(flat2, z2)));
  const vf twice_cos = sqrt_f(flat2 + z2);  // |wo + wi| = 2 wo . h
  BsdfValue value;
  // The alpha of microfacets that spread as much [Walter et al. 2007, section 5.2].
  const vf alpha = sqrt_f(div_f((vf)(2.0f), m.own.phong_shininess + 2.0f)), fade = diffuse_terminator(m, wi);
  value.f = scale3(add3(scale3(k.base, fade), scale3(m.own.phong_specular, (k.scale * power) * glossy_terminator(fade, alpha))), wi.z);
  const vf highlight = div_f(((m.own.phong_shininess + 1.0f) * EK_INV_2PI) * power, 2.0f * twice_cos);
  value.pdf = k.p_highlight * highlight + (1.0f - k.p_highlight) * (EK_INV_PI * wi.z);
  return bsdf_value_if(valid, value);
}

EK_FN BsdfValue phong_evaluate(MaterialLanes m, v3 wo, v3 wi) { return phong_value(m, make_phong(m), wo, wi); }

EK_FN BsdfSample phong_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const Phong k = make_phong(m);
  // 1 - cos_h comes from its series where it is small: rounded cosines would turn sharp highlights
  // into rings.
  const vf power = div_f(log2_f(1.0f - v), m.own.phong_shininess + 1.0f), y = -0.693147181f * power;
  const vf series = y * (1.0f - y * (0.5f - y * (0.166666667f - y * (0.0416666667f - y * 0.00833333333f))));
  const vf rest = y < 0.25f ? series : 1.0f - exp2_f(power);
  const vf cos_h = 1.0f - rest, sin_h = sqrt_f(rest * (2.0f - rest));
  vf s, c;
  sincos_2pi(u, &s, &c);
  const v3 reflected = normalize3(mirrored(wo, V3(sin_h * c, sin_h * s, cos_h)));
  const v3 wi = select3(choice < k.p_highlight, reflected, warp_cosine_hemisphere(u, v));
  return bsdf_sample_of(phong_value(m, k, wo, wi), wi, (vi)(0));
}

#endif
