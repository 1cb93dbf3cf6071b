// SPDX-License-Identifier: Apache-2.0
// Lambert's lobe: f = base_color / pi.
#ifndef EK_BSDF_DIFFUSE_H
#define EK_BSDF_DIFFUSE_H
#include "bsdf/lobe.h"
#include "bsdf/terminator.h"
#include "lanes/warp.h"

EK_FN BsdfValue diffuse_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
  vf f = above ? wi.z * EK_INV_PI : (vf)(0.0f);
  if (EK_USES_GEOMETRIC_NORMAL) f = f * diffuse_terminator(m, wi);
  BsdfValue value = {scale3(m.base_color, f), above ? diffuse_pdf(m, wi) : (vf)(0.0f)};
  return value;
}

// Directions are sampled by the cosine, so eval / pdf is the base colour itself, times the
// terminator's factor, over the density of guiding.
EK_FN BsdfSample diffuse_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  (void)choice;
  vf over_cosine;
  const v3 wi = diffuse_direction(m, u, v, &over_cosine);
  const vf pdf = ((wo.z > 0.0f) & (wi.z > 0.0f)) ? (wi.z * EK_INV_PI) * over_cosine : (vf)(0.0f);
  BsdfSample s = {m.base_color, wi, pdf, (vi)(0)};
  if (EK_USES_GUIDE) s.weight = scale3(s.weight, div_f(1.0f, over_cosine));
  if (EK_USES_GEOMETRIC_NORMAL) s.weight = scale3(s.weight, diffuse_terminator(m, wi));
  return s;
}

#endif
