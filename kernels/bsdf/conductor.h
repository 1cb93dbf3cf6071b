// SPDX-License-Identifier: Apache-2.0
// Bare metal with a complex index of refraction (EIKON_materials_conductor): GGX microfacets that
// reflect by Fresnel's equations, times the base colour, under a thin film where the material has
// one. Light that microfacets reflect to each other is lost, as with glTF's metals, unless
// --energy-compensation is set.
#ifndef EK_BSDF_CONDUCTOR_H
#define EK_BSDF_CONDUCTOR_H
#include "bsdf/lobe.h"
#include "bsdf/metallic_roughness.h"
#if EK_HAS_iridescence
#include "bsdf/thin_film_metal.h"
#endif

// Reflectance without a thin film.
EK_FN v3 bare_reflectance(MaterialLanes m, vf cosine) {
  return mul3(m.base_color, V3(fresnel_conductor(cosine, m.own.conductor_eta.x, m.own.conductor_k.x),
                               fresnel_conductor(cosine, m.own.conductor_eta.y, m.own.conductor_k.y),
                               fresnel_conductor(cosine, m.own.conductor_eta.z, m.own.conductor_k.z)));
}

EK_FN v3 conductor_reflectance(MaterialLanes m, vf cosine) {
  const v3 bare = bare_reflectance(m, cosine);
#if EK_HAS_iridescence
  if (ANY(m.iridescence > 0.0f)) {
    const ThinFilm film = {m.thin_film_index, m.thin_film_thickness};
    const v3 with_film = thin_film_conductor_reflectance(film, m.own.conductor_eta, m.own.conductor_k, min_f(cosine, (vf)(1.0f)));
    const v3 both = add3(scale3(bare, 1.0f - m.iridescence), scale3(mul3(m.base_color, with_film), m.iridescence));
    return select3(m.iridescence > 0.0f, both, bare);
  }
#endif
  return bare;
}

#if EK_HAS_energy_compensation
// 2 times the integral of the reflectance over the cosine times the cosine, by Gaussian quadrature
// over the squared cosine: three nodes, and EK_THIN_FILM_NODES under a film.
EK_FN v3 conductor_mean_reflectance(MaterialLanes m) {
  v3 mean = add3(scale3(add3(bare_reflectance(m, (vf)(0.335710687f)), bare_reflectance(m, (vf)(0.941965058f))), 5.0f / 18.0f),
                 scale3(bare_reflectance(m, (vf)(0.707106781f)), 8.0f / 18.0f));
#if EK_HAS_iridescence
  if (ANY(m.iridescence > 0.0f)) {
    v3 with_film = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
    for (uint i = 0; i < EK_THIN_FILM_NODES; ++i)
      with_film = add3(with_film, scale3(conductor_reflectance(m, (vf)(thin_film_cosines[i])), (vf)(thin_film_weights[i])));
    mean = select3(m.iridescence > 0.0f, with_film, mean);
  }
#endif
  return mean;
}
#endif

// The terms that depend on wo alone.
typedef struct {
  vi smooth;
  GgxAlpha alpha;
  vf length_o;
#if EK_HAS_energy_compensation
  v3 ms_lobe;    // f of multiple scattering is ms_lobe one_minus_E(wi)
#endif
  vf p_single;   // probability of sampling single scattering
} Conductor;

EK_FN Conductor make_conductor(MaterialLanes m, v3 wo) {
  Conductor k;
  k.smooth = is_smooth(m);
  k.alpha = alpha_of(m);
  k.length_o = ggx_length(wo, k.alpha);
  k.p_single = (vf)(1.0f);
#if EK_HAS_energy_compensation
  const v3 mean_f = conductor_mean_reflectance(m);
  const vf one_minus_avg = max_f(one_minus_E_avg(k.alpha), (vf)(0x1p-30f));
  const vf one_minus_E_o = one_minus_E(k.alpha, wo.z, k.length_o);
  const v3 ms_albedo = scale3(ms_fresnel3(mean_f, one_minus_avg), k.smooth ? (vf)(0.0f) : one_minus_E_o);
  k.ms_lobe = scale3(ms_albedo, div_f(EK_INV_PI, one_minus_avg));
  const vf ss_albedo = max_f(mean_component(mean_f) * (1.0f - one_minus_E_o), (vf)(0x1p-20f));
  k.p_single = div_f(ss_albedo, ss_albedo + mean_component(ms_albedo));
#endif
  return k;
}

EK_FN BsdfValue conductor_value(MaterialLanes m, Conductor k, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f) & !k.smooth;
  const v3 sum = add3(wo, wi);
  const vf sum2 = dot3(sum, sum);
  const vf d = ggx_d(direction_of(sum, sum2), k.alpha), length_i = ggx_length(wi, k.alpha);
  const v3 f = conductor_reflectance(m, min_f(0.5f * sqrt_f(sum2), (vf)(1.0f)));
  const vf fade = diffuse_terminator(m, wi), single = (d * ggx_visibility(wo.z, k.length_o, wi.z, length_i)) * glossy_terminator(fade, m.ggx_alpha);
  BsdfValue value = {scale3(f, single), 0.5f * d * ggx_visible_share(wo.z, k.length_o)};
#if EK_HAS_energy_compensation
  value.f = add3(value.f, scale3(k.ms_lobe, (one_minus_E(k.alpha, wi.z, length_i) * wi.z) * fade));
  value.pdf = k.p_single * value.pdf + (1.0f - k.p_single) * (EK_INV_PI * wi.z);
#endif
  return bsdf_value_if(valid, value);
}

EK_FN BsdfValue conductor_evaluate(MaterialLanes m, v3 wo, v3 wi) { return conductor_value(m, make_conductor(m, wo), wo, wi); }

EK_FN BsdfSample conductor_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const Conductor k = make_conductor(m, wo);
  const v3 rough = normalize3(mirrored(wo, ggx_visible_normal(wo, k.alpha, u, v)));
  v3 wi = select3(k.smooth, V3(-wo.x, -wo.y, wo.z), rough);
  if (EK_HAS_energy_compensation) wi = select3(!k.smooth & (choice >= k.p_single), warp_cosine_hemisphere(u, v), wi);
  BsdfValue value = conductor_value(m, k, wo, wi);
  value.f = select3(k.smooth, conductor_reflectance(m, wo.z), value.f);
  value.pdf = (k.smooth & (wo.z > 0.0f)) ? (vf)(1.0f) : value.pdf;
  return bsdf_sample_of(value, wi, k.smooth);
}

#endif
