// SPDX-License-Identifier: Apache-2.0
// The layers on a material: sheen [KHR_materials_sheen], and a coat over all
// [KHR_materials_clearcoat], mixed as the extensions say:
//   f = (1 - coat) (sheen color f_sheen + s f_base) + coat f_coat,
//   s = 1 - max(sheen color) max(E(wo), E(wi))
// with `coat` the coat's share at the angle of view and E the albedo of the sheen, which keeps the
// sum of sheen and base reciprocal. No layer returns more light than arrives. Lobes do not know of
// layers.
#ifndef EK_BSDF_LAYERS_H
#define EK_BSDF_LAYERS_H
#include "bsdf/clearcoat.h"
#include "bsdf/lobe.h"
#include "bsdf/sheen.h"

#define EK_LAYERED (EK_HAS_clearcoat | EK_HAS_sheen)

typedef struct {
  Coat coat;
  Sheen sheen;
  vf sheen_most;    // greatest channel of the sheen's colour
  vf sheen_o;       // albedo of the sheen at wo
  vf p_base, p_coat, p_sheen;
} CoatSheen;

/// Mask of the lanes whose material has layers.
EK_FN vi has_layers(MaterialLanes m) { return (m.clearcoat > 0.0f) | (max_component(m.sheen) > 0.0f); }

EK_FN CoatSheen make_coat_sheen(MaterialLanes m, v3 wo) {
  CoatSheen k;
  vf coat = (vf)(0.0f), fibres = (vf)(0.0f);
  k.sheen_most = k.sheen_o = (vf)(0.0f);
  if (EK_HAS_clearcoat) {
    k.coat = make_coat(m.clearcoat, m.clearcoat_alpha, m.clearcoat_normal, wo);
    coat = k.coat.share;
  }
  if (EK_HAS_sheen) {
    k.sheen = make_sheen(m.sheen_roughness);
    k.sheen_most = max_component(m.sheen);
    k.sheen_o = sheen_albedo(k.sheen, wo.z);
    fibres = mean_component(m.sheen) * k.sheen_o;
  }
  // Probabilities are about in proportion to what each part scatters. The base always gets some,
  // since it may reflect more at other angles.
  const vf base = (1.0f - k.sheen_most * k.sheen_o) * max_f(mean_component(m.base_color), (vf)(0.125f));
  const vf below = 1.0f - coat;
  const vf all = below * (base + fibres) + coat;
  const vf scale = div_f(1.0f, max_f(all, (vf)(0x1p-100f)));
  k.p_coat = coat * scale;
  k.p_sheen = (below * fibres) * scale;
  k.p_base = max_f(1.0f - (k.p_coat + k.p_sheen), (vf)(0.0f));
  return k;
}

/// The factor that the layers put on the base's f.
EK_FN vf base_transmittance(CoatSheen k, vf cos_i) {
  vf passes = (vf)(1.0f);
  if (EK_HAS_sheen) passes = 1.0f - k.sheen_most * max_f(k.sheen_o, sheen_albedo(k.sheen, abs_f(cos_i)));
  if (EK_HAS_clearcoat) passes = passes * (1.0f - k.coat.share);
  return passes;
}

/// eval and pdf of the material with its layers.
/// base  eval and pdf of its lobe alone
EK_FN BsdfValue layered_value(MaterialLanes m, CoatSheen k, v3 wo, v3 wi, BsdfValue base) {
  BsdfValue value = {scale3(base.f, base_transmittance(k, wi.z)), base.pdf * k.p_base};
  const vi above = (wo.z > 0.0f) & (wi.z > 0.0f);
  if (EK_HAS_sheen) {
    vf f = (sheen_f(k.sheen, wo, wi) * wi.z) * diffuse_terminator(m, wi);
    if (EK_HAS_clearcoat) f = f * (1.0f - k.coat.share);
    value.f = add3(value.f, scale3(m.sheen, above ? f : (vf)(0.0f)));
    value.pdf = value.pdf + (above ? k.p_sheen * EK_INV_2PI : (vf)(0.0f));
  }
  if (EK_HAS_clearcoat) {
    value.f = scale3(value.f, is_on_one_side(m, wi) ? (vf)(1.0f) : (vf)(0.0f));
    const BsdfValue coat = coat_value(m, k.coat, wi);
    value.f = add3(value.f, scale3(coat.f, k.coat.share));
    value.pdf = value.pdf + k.p_coat * coat.pdf;
  }
  return value;
}

#endif
