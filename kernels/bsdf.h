// SPDX-License-Identifier: Apache-2.0
// How surfaces scatter. The contract of every lobe:
//   frame   local, n = +z, on the viewer's side: the caller turns its basis so that wo.z > 0, whichever side was hit.
//   wo, wi  unit, to the viewer and to the light, both away from the surface.
//   eval    f(wo, wi) |cos theta_i|, per sr.
//   pdf     density of sample() for wi, per sr.
//   sample  weight = eval / pdf, wi, pdf. Failure is pdf 0; nothing else is to be used then.
// A wo in or below the tangent plane scatters nothing: eval and pdf are 0. A material has one lobe of features.def.
#ifndef EK_BSDF_H
#define EK_BSDF_H
#include "math.h"
#include "warp.h"

// A MaterialRecord, one per lane.
typedef struct {
  v3 albedo;
  v3 emission;      // radiance, W / (sr m^2)
  vu lobes;         // bit set
  vi double_sided;  // mask: emits on both sides
} MaterialLanes;

EK_FN MaterialLanes load_material(global const MaterialRecord* materials, vu i) {
  const Rec r = rec16(materials, i);
  MaterialLanes m = {V3(r.w0, r.w1, r.w2), V3(r.w3, r.w4, r.w5), AS_U(r.w6), AS_U(r.w7) != 0u};
  return m;
}

typedef struct {
  v3 weight;  // eval / pdf
  v3 wi;      // local, unit
  vf pdf;     // per sr; 0: nothing sampled
} BsdfSample;

#include "bsdf_diffuse.h"

/// f |cos theta_i| of the lobes of m that this program has.
EK_FN v3 bsdf_eval(MaterialLanes m, v3 wo, v3 wi) {
  v3 f = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
#define EK_LOBE(name, bit)                                    \
  if (EK_HAS_##name) {                                        \
    const vi has = (m.lobes & (1u << bit)) != 0u;             \
    if (ANY(has)) f = select3(has, name##_eval(m, wo, wi), f); \
  }
#include "shared/features.def"
  return f;
}

/// Density with which bsdf_sample chooses wi.
EK_FN vf bsdf_pdf(MaterialLanes m, v3 wo, v3 wi) {
  if (EK_HAS_uniform_scatter) {
    const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
    return above ? (vf)(EK_INV_2PI) : (vf)(0.0f);
  }
  vf pdf = (vf)(0.0f);
#define EK_LOBE(name, bit)                                 \
  if (EK_HAS_##name) {                                     \
    const vi has = (m.lobes & (1u << bit)) != 0u;          \
    if (ANY(has)) pdf = has ? name##_pdf(m, wo, wi) : pdf; \
  }
#include "shared/features.def"
  return pdf;
}

/// Samples wi. u, v: [0,1)^2, the direction; choice: [0,1), for lobes that scatter in several ways.
EK_FN BsdfSample bsdf_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  BsdfSample s = {V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), (vf)(0.0f)};
  if (EK_HAS_uniform_scatter) {
    s.wi = warp_uniform_hemisphere(u, v);
    s.pdf = bsdf_pdf(m, wo, s.wi);
    s.weight = scale3(bsdf_eval(m, wo, s.wi), (vf)(2.0f * EK_PI));
    return s;
  }
#define EK_LOBE(name, bit)                                              \
  if (EK_HAS_##name) {                                                  \
    const vi has = (m.lobes & (1u << bit)) != 0u;                       \
    if (ANY(has)) {                                                     \
      const BsdfSample lobe = name##_sample(m, wo, u, v, choice);       \
      s.weight = select3(has, lobe.weight, s.weight);                   \
      s.wi = select3(has, lobe.wi, s.wi);                               \
      s.pdf = has ? lobe.pdf : s.pdf;                                   \
    }                                                                   \
  }
#include "shared/features.def"
  return s;
}

#endif
