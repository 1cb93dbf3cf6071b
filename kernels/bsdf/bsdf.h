// SPDX-License-Identifier: Apache-2.0
// How surfaces scatter. The contract of every lobe:
//   frame   local, n = +z, on the viewer's side: the caller turns its basis so that wo.z > 0, whichever side was hit.
//           wi.z > 0 reflects, wi.z < 0 transmits.
//   wo, wi  unit, to the viewer and to the light, both away from the surface.
//   eval    f(wo, wi) |cos theta_i|, per sr, of all parts of the lobe that are not delta.
//   pdf     density of sample() for wi, per sr: of the parts that are not delta, with the probabilities of choosing them.
//   sample  weight = eval / pdf, wi, pdf. Failure is pdf 0; nothing else is to be used then. With `delta` set, wi is the one
//           direction of a delta part, pdf the probability of choosing that part, weight its share of the light over pdf.
// A wo in or below the tangent plane scatters nothing: eval and pdf are 0. A material has one lobe of features.def, and may have
// layers on it, which no lobe knows of.
#ifndef EK_BSDF_H
#define EK_BSDF_H
#include "lanes/math.h"
#include "lanes/warp.h"

// The parameters of a material at a hit, one per lane (material.h makes them).
typedef struct {
  vu lobes;          // bit set of EK_LOBE
  v3 base_color;     // linear, [0, 1]
  vf metallic;       // [0, 1]
  vf ggx_alpha;      // square of glTF's roughness
  vf ggx_alpha_x;    // the same along x, which is the direction of anisotropy; not less
  v3 f0_dielectric;  // reflectance at normal incidence of the dielectric part
  vf specular;       // its reflectance at grazing incidence: KHR_materials_specular's factor, [0, 1]
  v3 f0;             // the same two of the whole surface, with its metallic part
  vf f90;
  vf transmission;   // share of what enters the dielectric part that passes through, [0, 1]
  vf diffuse_transmission;  // share of the diffuse base that light passes, [0, 1], and the colour of what passes
  v3 diffuse_transmission_color;
  vi solid;          // passes by refraction; else the surface is a thin wall
  vf eta;            // index of refraction of the far side over that of wo's side, for solids
  // What lies on it (bsdf/layers.h).
  vf clearcoat;        // [0, 1]
  vf clearcoat_alpha;  // square of glTF's roughness
  v3 clearcoat_normal; // local, unit, on wo's side
  v3 sheen;            // colour of the fibres, [0, 1]
  vf sheen_roughness;  // [0, 1]
  vf iridescence;      // share of the surface under a thin film, [0, 1]
  vf film_index;       // of the film over that of air
  vf film_thickness;   // metres
  vf phong_shininess;
  v3 phong_specular;   // [0, 1]
  v3 conductor_eta, conductor_k;  // complex index of refraction
  global const float* measured;   // tables of all materials; the same for all lanes
  vu measured_table;              // where this one's begins
} MaterialLanes;

// Bits of MaterialLanes.lobes.
enum {
#define EK_LOBE(name, bit) LOBE_##name = bit,
#include "shared/features.def"
};

typedef struct {
  v3 weight;  // eval / pdf
  v3 wi;      // local, unit
  vf pdf;     // per sr; 0: nothing sampled
  vi delta;   // mask
} BsdfSample;

// eval and pdf of one pair of directions; a lobe's `evaluate` gives both, since they share most of their work.
typedef struct {
  v3 f;    // f |cos theta_i|
  vf pdf;  // per sr
} BsdfValue;

// Nothing, where m is not set.
EK_FN BsdfValue bsdf_value_if(vi m, BsdfValue value) {
  const vf zero = (vf)(0.0f);
  BsdfValue r = {select3(m, value.f, V3(zero, zero, zero)), m ? value.pdf : zero};
  return r;
}

// value: of wi, or of the delta part where `delta` is set.
EK_FN BsdfSample bsdf_sample_of(BsdfValue value, v3 wi, vi delta) {
  const vi some = value.pdf > 0x1p-100f;
  const vf zero = (vf)(0.0f);
  BsdfSample s = {select3(some, scale3(value.f, (vf)(1.0f) / value.pdf), V3(zero, zero, zero)),
                  select3(some, wi, V3(zero, zero, (vf)(1.0f))),
                  some ? value.pdf : zero, some & delta};
  return s;
}

#include "bsdf/diffuse.h"
#include "bsdf/metallic_roughness.h"
#include "bsdf/transmission.h"
#include "bsdf/conductor.h"
#include "bsdf/phong.h"
#include "bsdf/measured.h"

#include "bsdf/layers.h"

// Whether EK_HAS_uniform_scatter replaces the lobe's own sampling: nothing but Lambert's can do without it.
EK_FN vi scatters_uniformly(MaterialLanes m) { return (m.lobes & (1u << LOBE_diffuse)) != 0u; }

// Of the lobes of m that this program has, without what lies on them.
EK_FN BsdfValue lobe_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  BsdfValue value = {V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), (vf)(0.0f)};
#define EK_LOBE(name, bit)                                 \
  if (EK_HAS_##name) {                                     \
    const vi has = (m.lobes & (1u << bit)) != 0u;          \
    if (ANY(has)) {                                        \
      const BsdfValue lobe = name##_evaluate(m, wo, wi);   \
      value.f = select3(has, lobe.f, value.f);             \
      value.pdf = has ? lobe.pdf : value.pdf;              \
    }                                                      \
  }
#include "shared/features.def"
  if (EK_HAS_uniform_scatter) {
    const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
    value.pdf = scatters_uniformly(m) ? (above ? (vf)(EK_INV_2PI) : (vf)(0.0f)) : value.pdf;
  }
  return value;
}

/// eval and pdf of m: the density with which bsdf_sample chooses wi.
EK_FN BsdfValue bsdf_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  BsdfValue value = lobe_evaluate(m, wo, wi);
  if (EK_LAYERED) {
    const vi finished = has_finish(m);
    if (ANY(finished)) {
      const BsdfValue all = finished_value(m, make_finish(m, wo), wo, wi, value);
      value.f = select3(finished, all.f, value.f);
      value.pdf = finished ? all.pdf : value.pdf;
    }
  }
  return value;
}

/// f |cos theta_i|.
EK_FN v3 bsdf_eval(MaterialLanes m, v3 wo, v3 wi) { return bsdf_evaluate(m, wo, wi).f; }

// As bsdf_sample, without what lies on the lobes.
EK_FN BsdfSample lobe_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  BsdfSample s = {V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), (vf)(0.0f), (vi)(0)};
#define EK_LOBE(name, bit)                                              \
  if (EK_HAS_##name) {                                                  \
    const vi has = (m.lobes & (1u << bit)) != 0u;                       \
    if (ANY(has)) {                                                     \
      const BsdfSample lobe = name##_sample(m, wo, u, v, choice);       \
      s.weight = select3(has, lobe.weight, s.weight);                   \
      s.wi = select3(has, lobe.wi, s.wi);                               \
      s.pdf = has ? lobe.pdf : s.pdf;                                   \
      s.delta = has ? lobe.delta : s.delta;                             \
    }                                                                   \
  }
#include "shared/features.def"
  if (EK_HAS_uniform_scatter) {
    const vi uniform = scatters_uniformly(m);
    const v3 wi = warp_uniform_hemisphere(u, v);
    const BsdfValue value = lobe_evaluate(m, wo, wi);
    s.weight = select3(uniform, scale3(value.f, (vf)(2.0f * EK_PI)), s.weight);
    s.wi = select3(uniform, wi, s.wi);
    s.pdf = uniform ? value.pdf : s.pdf;
  }
  return s;
}

/// Samples wi. u, v: [0,1)^2, the direction; choice: [0,1), for materials that scatter in several ways.
EK_FN BsdfSample bsdf_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const vi finished = EK_LAYERED ? has_finish(m) : (vi)(0);
  if (!EK_LAYERED) return lobe_sample(m, wo, u, v, choice);
  if (!ANY(finished)) return lobe_sample(m, wo, u, v, choice);
  const Finish k = make_finish(m, wo);
  const vi from_base = choice < k.p_base;
  // Where nothing lies on the lobe p_base is 1, and this its own sample.
  const BsdfSample base = lobe_sample(m, wo, u, v, min_f(choice / k.p_base, (vf)(1.0f - 0x1p-24f)));
  v3 wi = base.wi;
  vi from_coat = (vi)(0);
  if (EK_HAS_clearcoat) {
    from_coat = !from_base & (choice < k.p_base + k.p_coat);
    wi = select3(from_coat, coat_direction(k.coat, wo, u, v), wi);
  }
  if (EK_HAS_sheen) wi = select3(!(from_base | from_coat), warp_uniform_hemisphere(u, v), wi);
  BsdfValue value = finished_value(m, k, wo, wi, lobe_evaluate(m, wo, wi));
  const vi base_delta = from_base & base.delta, coat_delta = EK_HAS_clearcoat ? from_coat & k.coat.smooth : (vi)(0);
  value.f = select3(base_delta, scale3(base.weight, base.pdf * finish_passes(k, wi.z)), value.f);
  value.pdf = base_delta ? base.pdf * k.p_base : value.pdf;
  if (EK_HAS_clearcoat) {
    value.f = select3(coat_delta, V3(k.coat.share, k.coat.share, k.coat.share), value.f);
    value.pdf = coat_delta ? k.p_coat : value.pdf;
  }
  const vi valid = (wo.z > 0.0f) & (from_base ? base.pdf > 0.0f : wi.z > 0.0f);
  BsdfSample s = bsdf_sample_of(bsdf_value_if(valid, value), wi, base_delta | coat_delta);
  s.weight = select3(finished, s.weight, base.weight);
  s.wi = select3(finished, s.wi, base.wi);
  s.pdf = finished ? s.pdf : base.pdf;
  s.delta = finished ? s.delta : base.delta;
  return s;
}

#endif
