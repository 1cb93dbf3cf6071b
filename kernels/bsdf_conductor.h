// SPDX-License-Identifier: Apache-2.0
// Bare metal by its complex index of refraction (EIKON_materials_conductor): GGX microfacets that reflect by Fresnel's equations,
// times the base colour. What microfacets reflect to each other is lost, as of glTF's metals.
#ifndef EK_BSDF_CONDUCTOR_H
#define EK_BSDF_CONDUCTOR_H
#include "bsdf_metallic_roughness.h"

EK_FN v3 conductor_reflectance(MaterialLanes m, vf cosine) {
  return mul3(m.base_color, V3(fresnel_conductor(cosine, m.conductor_eta.x, m.conductor_k.x),
                               fresnel_conductor(cosine, m.conductor_eta.y, m.conductor_k.y),
                               fresnel_conductor(cosine, m.conductor_eta.z, m.conductor_k.z)));
}

EK_FN BsdfValue conductor_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f) & !is_smooth(m);
  const GgxAlpha alpha = alpha_of(m);
  const v3 sum = add3(wo, wi);
  const vf sum2 = dot3(sum, sum);
  const vf d = ggx_d(direction_of(sum, sum2), alpha), length_o = ggx_length(wo, alpha);
  const v3 f = conductor_reflectance(m, min_f(0.5f * sqrt(sum2), (vf)(1.0f)));
  BsdfValue value = {scale3(f, d * ggx_visibility(wo.z, length_o, wi.z, ggx_length(wi, alpha))),
                     0.5f * d * ggx_visible_share(wo.z, length_o)};
  return bsdf_value_if(valid, value);
}

EK_FN BsdfSample conductor_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  (void)choice;
  const vi mirror = is_smooth(m);
  const v3 rough = normalize3(mirrored(wo, ggx_visible_normal(wo, alpha_of(m), u, v)));
  const v3 wi = select3(mirror, V3(-wo.x, -wo.y, wo.z), rough);
  BsdfValue value = conductor_evaluate(m, wo, wi);
  value.f = select3(mirror, conductor_reflectance(m, wo.z), value.f);
  value.pdf = (mirror & (wo.z > 0.0f)) ? (vf)(1.0f) : value.pdf;
  return bsdf_sample_of(value, wi, mirror);
}

#endif
