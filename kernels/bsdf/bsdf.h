// SPDX-License-Identifier: Apache-2.0
// Scattering at surfaces. The contract of every lobe:
//   frame   Local, n = +z on the viewer's side: the caller turns its basis so that wo.z > 0,
//           whichever side was hit. wi.z > 0 reflects, wi.z < 0 transmits.
//   wo, wi  Unit, to the viewer and to the light, both away from the surface.
//   eval    f(wo, wi) |cos theta_i|, per sr, of all parts of the lobe that are not delta. What is
//           reflected has the factor of terminator.h.
//   pdf     Density with which sample() chooses wi, per sr, of the parts that are not delta; it
//           includes the probability of choosing a part.
//   sample  wi, pdf and weight = eval / pdf. A failure has pdf 0, and its other members mean
//           nothing. With `delta` set, wi is the one direction of a delta part, pdf the probability
//           of choosing that part, and weight the part's share of the light over pdf.
// If wo lies in or below the tangent plane nothing is scattered: eval and pdf are 0. A material has
// one lobe of features.def. It may have layers on top (layers.h), of which no lobe knows. A coat
// may have a normal other than the frame's, and reflects to directions above the surface itself
// with wi.z < 0, too.
#ifndef EK_BSDF_H
#define EK_BSDF_H
#include "bsdf/conductor.h"
#include "bsdf/diffuse.h"
#include "bsdf/layers.h"
#include "bsdf/lobe.h"
#include "bsdf/measured.h"
#include "bsdf/metallic_roughness.h"
#include "bsdf/phong.h"
#include "bsdf/transmission.h"
#include "lanes/warp.h"

// With EK_HAS_uniform_scatter this mask tells which lanes replace their own sampling: Lambert's
// alone, since no other lobe can be sampled uniformly at a bearable variance.
EK_FN vi scatters_uniformly(MaterialLanes m) { return has_trait(m.lobes, EK_TRAIT_LAMBERT); }

// eval and pdf of the lobe of m, without the layers on it.
EK_FN BsdfValue lobe_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  BsdfValue value = {V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), (vf)(0.0f)};
#define EK_LOBE(name, bit, traits)                         \
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

/// eval and pdf of m; pdf is the density with which bsdf_sample chooses wi.
EK_FN BsdfValue bsdf_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  BsdfValue value = lobe_evaluate(m, wo, wi);
  if (EK_LAYERED) {
    const vi layered = has_layers(m);
    if (ANY(layered)) {
      const BsdfValue all = layered_value(m, make_coat_sheen(m, wo), wo, wi, value);
      value.f = select3(layered, all.f, value.f);
      value.pdf = layered ? all.pdf : value.pdf;
    }
  }
  return value;
}

/// f |cos theta_i|.
EK_FN v3 bsdf_eval(MaterialLanes m, v3 wo, v3 wi) { return bsdf_evaluate(m, wo, wi).f; }

// bsdf_sample without the layers on the lobe.
EK_FN BsdfSample lobe_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  BsdfSample s = {V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), (vf)(0.0f), (vi)(0)};
#define EK_LOBE(name, bit, traits)                                      \
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

/// Samples wi.
/// u, v    [0,1)^2, for the direction
/// choice  [0,1), for materials that scatter in several ways
EK_FN BsdfSample bsdf_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const vi layered = EK_LAYERED ? has_layers(m) : (vi)(0);
  if (!EK_LAYERED) return lobe_sample(m, wo, u, v, choice);
  if (!ANY(layered)) return lobe_sample(m, wo, u, v, choice);
  const CoatSheen k = make_coat_sheen(m, wo);
  const vi from_base = choice < k.p_base;
  // A lane without layers has p_base 1, and this is its own sample.
  const BsdfSample base = lobe_sample(m, wo, u, v, min_f(div_f(choice, k.p_base), (vf)(1.0f - 0x1p-24f)));
  v3 wi = base.wi;
  vi from_coat = (vi)(0), above_coat = (vi)(0);
  if (EK_HAS_clearcoat) {
    from_coat = !from_base & (choice < k.p_base + k.p_coat);
    wi = select3(from_coat, coat_direction(m, k.coat, u, v, &above_coat), wi);
  }
  if (EK_HAS_sheen) wi = select3(!(from_base | from_coat), warp_uniform_hemisphere(u, v), wi);
  BsdfValue value = layered_value(m, k, wo, wi, lobe_evaluate(m, wo, wi));
  const vi base_delta = from_base & base.delta, coat_delta = EK_HAS_clearcoat ? from_coat & k.coat.smooth : (vi)(0);
  value.f = select3(base_delta, scale3(base.weight, (is_on_one_side(m, wi) ? base.pdf : (vf)(0.0f)) * base_transmittance(k, wi.z)), value.f);
  value.pdf = base_delta ? base.pdf * k.p_base : value.pdf;
  if (EK_HAS_clearcoat) {
    value.f = select3(coat_delta, V3(k.coat.share, k.coat.share, k.coat.share), value.f);
    value.pdf = coat_delta ? k.p_coat : value.pdf;
  }
  const vi above = from_coat ? above_coat : wi.z > 0.0f;
  const vi valid = (wo.z > 0.0f) & (from_base ? base.pdf > 0.0f : above);
  BsdfSample s = bsdf_sample_of(bsdf_value_if(valid, value), wi, base_delta | coat_delta);
  s.weight = select3(layered, s.weight, base.weight);
  s.wi = select3(layered, s.wi, base.wi);
  s.pdf = layered ? s.pdf : base.pdf;
  s.delta = layered ? s.delta : base.delta;
  return s;
}

#endif
