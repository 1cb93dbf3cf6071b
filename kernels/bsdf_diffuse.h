// SPDX-License-Identifier: Apache-2.0
// Lambert's lobe: f = albedo / pi.
#ifndef EK_BSDF_DIFFUSE_H
#define EK_BSDF_DIFFUSE_H
#include "warp.h"

EK_FN vf diffuse_pdf(MaterialLanes m, v3 wo, v3 wi) {
  (void)m;
  const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
  return above ? wi.z * EK_INV_PI : (vf)(0.0f);
}

EK_FN v3 diffuse_eval(MaterialLanes m, v3 wo, v3 wi) { return scale3(m.base_color, diffuse_pdf(m, wo, wi)); }

// Sampled by the cosine, so that eval / pdf is the albedo itself.
EK_FN BsdfSample diffuse_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  (void)choice;
  const v3 wi = warp_cosine_hemisphere(u, v);
  BsdfSample s = {m.base_color, wi, diffuse_pdf(m, wo, wi), (vi)(0)};
  return s;
}

#endif
