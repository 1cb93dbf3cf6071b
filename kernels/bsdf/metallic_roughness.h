// SPDX-License-Identifier: Apache-2.0
// glTF's opaque material [glTF 2.0, appendix B]: a GGX layer with Schlick's reflectance, over a diffuse base that fades as
// the surface turns metallic.
//
// The appendix mixes the two by the reflectance at the half vector; that gives back up to 1.9 times the light near grazing
// incidence. Here the base receives what the layer leaves, in and out: base (1 - E(wo)) (1 - E(wi)) / (pi (1 - E_avg)), with E the
// albedo of the layer [Kelemen and Szirmay-Kalos 2001, section 2]: reciprocal, never more than 1, and exactly 1 for a white
// base under a colourless layer of which nothing is lost.
#ifndef EK_BSDF_METALLIC_ROUGHNESS_H
#define EK_BSDF_METALLIC_ROUGHNESS_H
#include "bsdf/fresnel.h"
#include "bsdf/anisotropic_albedo.h"
#include "bsdf/ggx_albedo.h"
#include "bsdf/microfacet.h"
#if EK_HAS_energy_compensation
#include "bsdf/multiple_scattering.h"
#endif
#if EK_HAS_iridescence
#include "bsdf/thin_film.h"
#endif
#include "lanes/warp.h"

#if EK_HAS_iridescence
// Of the share of a surface that is under a film; f0: of the surface without it. plain: what the rest reflects at that angle.
EK_FN v3 with_film(MaterialLanes m, v3 plain, v3 f0, vf cosine) {
  const ThinFilm film = {m.film_index, m.film_thickness};
  const v3 f = film_reflectance(film, f0, cosine);
  return add3(scale3(plain, 1.0f - m.iridescence), scale3(f, m.iridescence));
}
#endif

/// Schlick's law, under a film as far as the material has one; share: of the surface that f0 and f90 are for, as their factor
EK_FN v3 surface_reflectance(MaterialLanes m, v3 f0, vf f90, vf share, vf cosine) {
  const v3 plain = schlick(f0, f90, schlick_weight(cosine));
#if EK_HAS_iridescence
  if (!ANY(m.iridescence > 0.0f)) return plain;
  const vf all = max_f(share, (vf)(0x1p-20f));
  const v3 under = with_film(m, scale3(plain, 1.0f / all), scale3(f0, 1.0f / all), cosine);
  return select3((m.iridescence > 0.0f) & (share > 0.0f), scale3(under, all), plain);
#else
  (void)m;
  (void)share;
  return plain;
#endif
}

EK_FN vf mean_component(v3 a) { return ((a.x + a.y) + a.z) * (1.0f / 3.0f); }

/// Whether the microfacets of m form a mirror: delta.
EK_FN vi is_smooth(MaterialLanes m) {
  const vi smooth = m.ggx_alpha < EK_SMOOTH_ALPHA;
  return EK_HAS_anisotropy ? smooth & (m.ggx_alpha_x < EK_SMOOTH_ALPHA) : smooth;
}

/// Their alpha, along x and y; where smooth, of none.
EK_FN GgxAlpha alpha_of(MaterialLanes m) {
  GgxAlpha a = ggx_isotropic(max_f(m.ggx_alpha, (vf)(EK_SMOOTH_ALPHA)));
  if (EK_HAS_anisotropy) a.x = max_f(m.ggx_alpha_x, (vf)(EK_SMOOTH_ALPHA));
  return a;
}

// What of a layer over a base depends on wo alone.
typedef struct {
  vi smooth;       // the layer is a mirror: delta
  GgxAlpha alpha;  // of the GGX lobe; where smooth, of none
  vf length_o;     // ggx_length(wo)
  GgxAlbedoFit albedo;  // of isotropic lanes
  vf e_f0, e_f90;  // of E: the dielectric's reflectance, its greatest channel
  vf kept;         // 1 - E(wo)
  vf enters;       // f of a base of albedo a is a enters (1 - E(wi))
  v3 base;         // the same times its albedo
#if EK_HAS_energy_compensation
  v3 again;        // f of light that metal reflects more than once is again metal_loses(wi)
#endif
  vf specular, diffuse;  // estimated albedos
} Layers;

// Of which lanes the two alphas differ.
EK_FN vi is_anisotropic(Layers k) { return EK_HAS_anisotropy ? !k.smooth & (k.alpha.x != k.alpha.y) : (vi)(0); }

EK_FN GgxAlbedo layer_albedo(Layers k, vf cosine, vf length) {
  GgxAlbedo a = ggx_albedo(k.albedo, cosine, length);
  const vi differs = is_anisotropic(k);
  if (!EK_HAS_anisotropy) return a;
  if (!ANY(differs)) return a;
  const GgxAlbedo other = anisotropic_albedo(k.alpha, cosine, length);
  a.full = differs ? other.full : a.full;
  a.grazing = differs ? other.grazing : a.grazing;
  return a;
}

EK_FN GgxAlbedo layer_mean_albedo(Layers k) {
  GgxAlbedo a = k.albedo.mean;
  const vi differs = is_anisotropic(k);
  if (!EK_HAS_anisotropy) return a;
  if (!ANY(differs)) return a;
  const GgxAlbedo other = anisotropic_mean_albedo(k.alpha);
  a.full = differs ? other.full : a.full;
  a.grazing = differs ? other.grazing : a.grazing;
  return a;
}

#if EK_HAS_energy_compensation
// What metal of these layers loses along a direction; smooth, nothing.
EK_FN vf metal_loses(Layers k, vf cosine, vf length) {
  const vf lost = mirrors_lose(k.alpha, cosine, length);
  return k.smooth ? (vf)(0.0f) : lost;
}
#endif

#if EK_HAS_energy_compensation
// 2 times the integral of metal's reflectance over the cosine times the cosine; under a film by Gauss's nodes.
EK_FN v3 metal_mean_reflectance(MaterialLanes m) {
  const v3 bare = add3(scale3(m.base_color, 20.0f / 21.0f), V3((vf)(1.0f / 21.0f), (vf)(1.0f / 21.0f), (vf)(1.0f / 21.0f)));
#if EK_HAS_iridescence
  if (ANY(m.iridescence > 0.0f)) {
    const vf one = (vf)(1.0f);
    v3 mean = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
    for (uint i = 0; i < EK_FILM_NODES; ++i)
      mean = add3(mean, scale3(surface_reflectance(m, m.base_color, one, one, (vf)(film_cosines[i])), (vf)(film_weights[i])));
    return select3(m.iridescence > 0.0f, mean, bare);
  }
#endif
  return bare;
}
#endif

/// f0, f90  of the layer;  share: of the surface that is such a layer;  base: albedo of the base by itself
EK_FN Layers make_layers(MaterialLanes m, v3 wo, v3 f0, vf f90, vf share, v3 base) {
  Layers k;
  k.smooth = is_smooth(m);
  k.alpha = alpha_of(m);
  k.length_o = ggx_length(wo, k.alpha);
  k.albedo = ggx_albedo_fit(k.smooth, k.alpha.y);
  k.e_f0 = max_component(m.f0_dielectric);
  k.e_f90 = m.specular;
#if EK_HAS_iridescence
  const ThinFilm film = {m.film_index, m.film_thickness};
  k.e_f0 = k.e_f0 + (film_most(film, k.e_f0) - k.e_f0) * m.iridescence;
  k.e_f90 = k.e_f90 + (1.0f - k.e_f90) * m.iridescence;
#endif
  const GgxAlbedo o = layer_albedo(k, wo.z, k.length_o);
  k.kept = 1.0f - ggx_reflected(o, k.e_f0, k.e_f90);
  const vf kept_mean = 1.0f - ggx_reflected(layer_mean_albedo(k), k.e_f0, k.e_f90);
  k.enters = (EK_INV_PI * k.kept) / max_f(kept_mean, (vf)(0x1p-20f));
  k.base = scale3(base, k.enters);
  // A floor, since the layer may reflect far more at other microfacets than on the whole.
  k.specular = max_f(ggx_reflected(o, mean_component(f0), f90), 0x1p-6f * f90);
#if EK_HAS_iridescence
  k.specular = m.iridescence > 0.0f ? max_f(o.full * mean_component(surface_reflectance(m, f0, f90, share, wo.z)), k.specular) : k.specular;
#else
  (void)share;
#endif
  k.diffuse = mean_component(base) * k.kept;
#if EK_HAS_energy_compensation
  // Of the metal alone: what a dielectric layer does not reflect, for whatever reason, its base receives.
  const vf lost = metal_loses(k, wo.z, k.length_o), lost_mean = max_f(mirrors_lose_mean(k.alpha), (vf)(0x1p-30f));
  const v3 once = metal_mean_reflectance(m);
  const v3 more = scale3(reflected_again3(once, lost_mean), m.metallic * lost);
  k.again = scale3(more, EK_INV_PI / lost_mean);
  k.diffuse = k.diffuse + mean_component(more);
#endif
  return k;
}

/// 1 - E(wi): what of the light that a base sends to wi the layer lets out.
EK_FN vf layers_let_out(Layers k, vf cos_i, vf length_i) {
  return 1.0f - ggx_reflected(layer_albedo(k, cos_i, length_i), k.e_f0, k.e_f90);
}

/// f cos_i of what leaves as from a diffuse surface: the base, and metal's light of several reflections.
EK_FN v3 layers_diffuse(Layers k, vf cos_i, vf length_i) {
  const vf let_out = layers_let_out(k, cos_i, length_i);
#if EK_HAS_energy_compensation
  return scale3(add3(scale3(k.base, let_out), scale3(k.again, metal_loses(k, cos_i, length_i))), cos_i);
#else
  return scale3(scale3(k.base, let_out), cos_i);
#endif
}

EK_FN Layers metallic_roughness_layers(MaterialLanes m, v3 wo) {
  return make_layers(m, wo, m.f0, m.f90, (vf)(1.0f), scale3(m.base_color, 1.0f - m.metallic));
}

EK_FN BsdfValue metallic_roughness_value(MaterialLanes m, Layers k, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f);
  const v3 sum = add3(wo, wi);
  const vf sum2 = dot3(sum, sum);
  const vf cos_h = 0.5f * sqrt(sum2);  // of wo or wi with the half vector, unlike a dot product the same for both
  const v3 h = direction_of(sum, sum2);
  const vf length_i = ggx_length(wi, k.alpha);
  const vf d = k.smooth ? (vf)(0.0f) : ggx_d(h, k.alpha);
  const v3 f = surface_reflectance(m, m.f0, m.f90, (vf)(1.0f), cos_h);
  BsdfValue value;
  value.f = add3(scale3(f, d * ggx_visibility(wo.z, k.length_o, wi.z, length_i)),
                 layers_diffuse(k, wi.z, length_i));
  value.pdf = (k.specular * (0.5f * d * ggx_visible_share(wo.z, k.length_o)) + k.diffuse * (EK_INV_PI * wi.z)) /
              (k.specular + k.diffuse);
  return bsdf_value_if(valid & (k.specular + k.diffuse > 0.0f), value);
}

EK_FN BsdfValue metallic_roughness_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  return metallic_roughness_value(m, metallic_roughness_layers(m, wo), wo, wi);
}

EK_FN BsdfSample metallic_roughness_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const Layers k = metallic_roughness_layers(m, wo);
  const vf p_specular = k.specular / (k.specular + k.diffuse);
  const vi reflect = choice < p_specular;
  const vi mirror = reflect & k.smooth;
  const v3 reflected = normalize3(mirrored(wo, ggx_visible_normal(wo, k.alpha, u, v)));
  v3 wi = select3(reflect, reflected, warp_cosine_hemisphere(u, v));
  wi = select3(mirror, V3(-wo.x, -wo.y, wo.z), wi);
  BsdfValue value = metallic_roughness_value(m, k, wo, wi);
  value.f = select3(mirror, surface_reflectance(m, m.f0, m.f90, (vf)(1.0f), wo.z), value.f);
  value.pdf = (mirror & (wo.z > 0.0f)) ? p_specular : value.pdf;
  return bsdf_sample_of(value, wi, mirror);
}

#endif
