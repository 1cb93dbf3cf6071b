// SPDX-License-Identifier: Apache-2.0
// Lambert's lobe: f = base_color / pi.
#ifndef EK_BSDF_DIFFUSE_H
#define EK_BSDF_DIFFUSE_H
#include "bsdf/lobe.h"
#include "lanes/warp.h"

EK_FN BsdfValue diffuse_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
  const vf pdf = above ? wi.z * EK_INV_PI : (vf)(0.0f);
  BsdfValue value = {scale3(m.base_color, pdf), pdf};
  return value;
}

// Directions are sampled by the cosine, so eval / pdf is the base colour itself.
EK_FN BsdfSample diffuse_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  (void)choice;
  const v3 wi = warp_cosine_hemisphere(u, v);
  BsdfSample s = {m.base_color, wi, diffuse_evaluate(m, wo, wi).pdf, (vi)(0)};
  return s;
}

#endif
