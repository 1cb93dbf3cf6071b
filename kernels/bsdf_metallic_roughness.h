// SPDX-License-Identifier: Apache-2.0
// glTF's opaque materials: a GGX layer over a diffuse base [glTF 2.0, appendix B].
#ifndef EK_BSDF_METALLIC_ROUGHNESS_H
#define EK_BSDF_METALLIC_ROUGHNESS_H
#include "warp.h"

EK_FN vf metallic_roughness_pdf(MaterialLanes m, v3 wo, v3 wi) {
  (void)m;
  const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
  return above ? wi.z * EK_INV_PI : (vf)(0.0f);
}

EK_FN v3 metallic_roughness_eval(MaterialLanes m, v3 wo, v3 wi) {
  return scale3(m.base_color, metallic_roughness_pdf(m, wo, wi));
}

EK_FN BsdfSample metallic_roughness_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  (void)choice;
  const v3 wi = warp_cosine_hemisphere(u, v);
  BsdfSample s = {m.base_color, wi, metallic_roughness_pdf(m, wo, wi), (vi)(0)};
  return s;
}

#endif
