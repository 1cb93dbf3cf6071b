// SPDX-License-Identifier: Apache-2.0
// glTF's opaque material [glTF 2.0, appendix B]: a GGX specular layer with Schlick's reflectance,
// over a diffuse base that fades as the surface turns metallic.
//
// The appendix mixes the two by the reflectance at the half vector, which returns up to 1.9 times
// the light near grazing incidence. Here the base has
//   base (1 - E(wo)) (1 - E(wi)) / (pi (1 - E_avg))
// with E the directional albedo of the layer [Kelemen and Szirmay-Kalos 2001, section 2]. That is
// reciprocal, never reflects more than 1, and exactly 1 for a white base under a colourless layer
// without loss.
#ifndef EK_BSDF_METALLIC_ROUGHNESS_H
#define EK_BSDF_METALLIC_ROUGHNESS_H
#include "bsdf/fresnel.h"
#include "bsdf/anisotropic_albedo.h"
#include "bsdf/ggx_albedo.h"
#include "bsdf/lobe.h"
#include "bsdf/microfacet.h"
#include "bsdf/terminator.h"
#if EK_HAS_energy_compensation
#include "bsdf/multiple_scattering.h"
#endif
#if EK_HAS_iridescence
#include "bsdf/thin_film.h"
#endif
#include "lanes/warp.h"

#if EK_HAS_iridescence
/// Reflectance of a surface of which m.iridescence is under a film.
/// plain  reflectance without the film at this angle;  f0  without the film at normal incidence
EK_FN v3 with_thin_film(MaterialLanes m, v3 plain, v3 f0, vf cosine) {
  const ThinFilm film = {m.thin_film_index, m.thin_film_thickness};
  const v3 f = thin_film_reflectance(film, f0, cosine);
  return add3(scale3(plain, 1.0f - m.iridescence), scale3(f, m.iridescence));
}
#endif

// The shares of a surface that are metal, and a dielectric layer over a base.
typedef struct {
  vf metal, dielectric;
} LayerShares;

/// The shares of a material that lets no light through.
EK_FN LayerShares layer_shares(MaterialLanes m) {
  const LayerShares shares = {m.metallic, 1.0f - m.metallic};
  return shares;
}

/// Schlick's law for metal and dielectric together, each under a thin film where the material has
/// one.
/// f0, f90  the sums of their reflectances times their shares. Films do not follow the sum, but
///          what each reflects: they reverse the phase of light, or do not, by the index of what
///          lies below.
EK_FN v3 surface_reflectance(MaterialLanes m, v3 f0, vf f90, LayerShares shares, vf cosine) {
  const v3 plain = schlick(f0, f90, schlick_weight(cosine));
#if EK_HAS_iridescence
  if (!ANY(m.iridescence > 0.0f)) return plain;
  const vf weight = schlick_weight(cosine), none = (vf)(0.0f);
  const vi metal = shares.metal > 0.0f, both = metal & (shares.dielectric > 0.0f);
  const v3 first_f0 = select3(metal, m.base_color, m.f0_dielectric);
  const v3 first = with_thin_film(m, schlick(first_f0, metal ? (vf)(1.0f) : m.specular, weight), first_f0, cosine);
  v3 with_film = scale3(first, metal ? shares.metal : shares.dielectric);
  if (ANY(both)) {
    const v3 second = with_thin_film(m, schlick(m.f0_dielectric, m.specular, weight), m.f0_dielectric, cosine);
    with_film = add3(with_film, scale3(second, both ? shares.dielectric : none));
  }
  return select3(m.iridescence > 0.0f, with_film, plain);
#else
  (void)m;
  (void)shares;
  return plain;
#endif
}

/// Mask of the lanes whose microfacets form a mirror, which is delta.
EK_FN vi is_smooth(MaterialLanes m) {
  const vi smooth = m.ggx_alpha < EK_SMOOTH_ALPHA;
  return EK_HAS_anisotropy ? smooth & (m.ggx_alpha_x < EK_SMOOTH_ALPHA) : smooth;
}

/// The alphas of the microfacets, at least EK_SMOOTH_ALPHA.
EK_FN GgxAlpha alpha_of(MaterialLanes m) {
  GgxAlpha a = ggx_isotropic(max_f(m.ggx_alpha, (vf)(EK_SMOOTH_ALPHA)));
  if (EK_HAS_anisotropy) a.x = max_f(m.ggx_alpha_x, (vf)(EK_SMOOTH_ALPHA));
  return a;
}

// The terms of a specular layer over a diffuse base that depend on wo alone.
typedef struct {
  vi smooth;       // the layer is a mirror: delta
  GgxAlpha alpha;  // of the GGX lobe, which smooth lanes do not use
  vf length_o;     // ggx_length(wo)
  GgxAlbedoFit albedo;  // of isotropic lanes
  vf e_f0, e_f90;  // reflectances that E is for: the greatest channel of the dielectric's
  vf one_minus_albedo_o;  // 1 - E(wo)
  vf base_scale;   // f of a base of albedo a is a base_scale (1 - E(wi))
  v3 base;         // base_scale times the albedo of the base
#if EK_HAS_energy_compensation
  v3 ms_lobe;      // metal's f of multiple scattering is ms_lobe metal_one_minus_E(wi)
#endif
  vf specular, diffuse;  // estimated albedos
} SpecularOverDiffuse;

// Mask of the lanes whose two alphas differ.
EK_FN vi is_anisotropic(SpecularOverDiffuse k) { return EK_HAS_anisotropy ? !k.smooth & (k.alpha.x != k.alpha.y) : (vi)(0); }

EK_FN GgxAlbedo specular_albedo(SpecularOverDiffuse k, vf cosine, vf length) {
  GgxAlbedo a = ggx_albedo(k.albedo, cosine, length);
  const vi differs = is_anisotropic(k);
  if (!EK_HAS_anisotropy) return a;
  if (!ANY(differs)) return a;
  const GgxAlbedo other = anisotropic_albedo(k.alpha, cosine, length);
  a.full = differs ? other.full : a.full;
  a.grazing = differs ? other.grazing : a.grazing;
  return a;
}

EK_FN GgxAlbedo specular_mean_albedo(SpecularOverDiffuse k) {
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
// 1 - E of the layer's microfacets if they reflect all light; 0 where they are smooth.
EK_FN vf metal_one_minus_E(SpecularOverDiffuse k, vf cosine, vf length) {
  const vf one_minus = one_minus_E(k.alpha, cosine, length);
  return k.smooth ? (vf)(0.0f) : one_minus;
}
// 2 times the integral of metal's reflectance over the cosine times the cosine; under a film by
// Gaussian quadrature.
EK_FN v3 metal_mean_reflectance(MaterialLanes m) {
  const v3 bare = add3(scale3(m.base_color, 20.0f / 21.0f), V3((vf)(1.0f / 21.0f), (vf)(1.0f / 21.0f), (vf)(1.0f / 21.0f)));
#if EK_HAS_iridescence
  if (ANY(m.iridescence > 0.0f)) {
    const vf one = (vf)(1.0f);
    v3 mean = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
    const LayerShares metal = {one, (vf)(0.0f)};
    for (uint i = 0; i < EK_THIN_FILM_NODES; ++i)
      mean = add3(mean, scale3(surface_reflectance(m, m.base_color, one, metal, (vf)(thin_film_cosines[i])), (vf)(thin_film_weights[i])));
    return select3(m.iridescence > 0.0f, mean, bare);
  }
#endif
  return bare;
}
#endif

/// f0, f90, shares  of the layer, as of surface_reflectance
/// base             albedo of the base alone
EK_FN SpecularOverDiffuse make_specular_over_diffuse(MaterialLanes m, v3 wo, v3 f0, vf f90, LayerShares shares, v3 base) {
  SpecularOverDiffuse k;
  k.smooth = is_smooth(m);
  k.alpha = alpha_of(m);
  k.length_o = ggx_length(wo, k.alpha);
  k.albedo = ggx_albedo_fit(k.smooth, k.alpha.y);
  k.e_f0 = max_component(m.f0_dielectric);
  k.e_f90 = m.specular;
#if EK_HAS_iridescence
  const ThinFilm film = {m.thin_film_index, m.thin_film_thickness};
  k.e_f0 = k.e_f0 + (thin_film_most_f0(film, k.e_f0) - k.e_f0) * m.iridescence;
  k.e_f90 = k.e_f90 + (1.0f - k.e_f90) * m.iridescence;
#endif
  const GgxAlbedo o = specular_albedo(k, wo.z, k.length_o);
  k.one_minus_albedo_o = 1.0f - ggx_reflected(o, k.e_f0, k.e_f90);
  const vf one_minus_albedo_avg = 1.0f - ggx_reflected(specular_mean_albedo(k), k.e_f0, k.e_f90);
  k.base_scale = div_f(EK_INV_PI * k.one_minus_albedo_o, max_f(one_minus_albedo_avg, (vf)(0x1p-20f)));
  k.base = scale3(base, k.base_scale);
  // The floor is there since single microfacets may reflect far more than the layer does on
  // average.
  k.specular = max_f(ggx_reflected(o, mean_component(f0), f90), 0x1p-6f * f90);
#if EK_HAS_iridescence
  k.specular = m.iridescence > 0.0f ? max_f(o.full * mean_component(surface_reflectance(m, f0, f90, shares, wo.z)), k.specular) : k.specular;
#else
  (void)shares;
#endif
  k.diffuse = mean_component(base) * k.one_minus_albedo_o;
#if EK_HAS_energy_compensation
  // This is for metal alone: the base of a dielectric receives whatever the layer does not reflect.
  const vf one_minus_E_o = metal_one_minus_E(k, wo.z, k.length_o), one_minus_avg = max_f(one_minus_E_avg(k.alpha), (vf)(0x1p-30f));
  const v3 mean_f = metal_mean_reflectance(m);
  const v3 ms_albedo = scale3(ms_fresnel3(mean_f, one_minus_avg), m.metallic * one_minus_E_o);
  k.ms_lobe = scale3(ms_albedo, div_f(EK_INV_PI, one_minus_avg));
  k.diffuse = k.diffuse + mean_component(ms_albedo);
#endif
  return k;
}

/// 1 - E(wi), the share of the base's light towards wi that the layer transmits.
EK_FN vf one_minus_albedo(SpecularOverDiffuse k, vf cos_i, vf length_i) {
  return 1.0f - ggx_reflected(specular_albedo(k, cos_i, length_i), k.e_f0, k.e_f90);
}

/// f cos_i of the diffuse base and of metal's multiple scattering.
EK_FN v3 diffuse_part(SpecularOverDiffuse k, vf cos_i, vf length_i) {
  const vf one_minus_albedo_i = one_minus_albedo(k, cos_i, length_i);
#if EK_HAS_energy_compensation
  return scale3(add3(scale3(k.base, one_minus_albedo_i), scale3(k.ms_lobe, metal_one_minus_E(k, cos_i, length_i))), cos_i);
#else
  return scale3(scale3(k.base, one_minus_albedo_i), cos_i);
#endif
}

EK_FN SpecularOverDiffuse metallic_roughness_terms(MaterialLanes m, v3 wo) {
  SpecularOverDiffuse k =
      make_specular_over_diffuse(m, wo, m.f0, m.f90, layer_shares(m), scale3(m.base_color, 1.0f - m.metallic));
#if EK_USES_GUIDE
  // Directions of the diffuse part come from the table, so a surface whose highlight is wide
  // follows the table sometimes even if all it reflects is the highlight.
  const vi wide = guide_has(m.guide) & (m.ggx_alpha >= EK_GUIDED_ALPHA);
  k.diffuse = wide ? max_f(k.diffuse, EK_GUIDED_SHARE * k.specular) : k.diffuse;
#endif
  return k;
}

EK_FN BsdfValue metallic_roughness_value(MaterialLanes m, SpecularOverDiffuse k, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f);
  const v3 sum = add3(wo, wi);
  const vf sum2 = dot3(sum, sum);
  const vf cos_h = 0.5f * sqrt_f(sum2);  // wo . h; exactly the same as wi . h
  const v3 h = direction_of(sum, sum2);
  const vf length_i = ggx_length(wi, k.alpha);
  const vf d = k.smooth ? (vf)(0.0f) : ggx_d(h, k.alpha);
  const v3 f = surface_reflectance(m, m.f0, m.f90, layer_shares(m), cos_h);
  const vf fade = diffuse_terminator(m, wi);
  BsdfValue value;
  value.f = add3(scale3(f, (d * ggx_visibility(wo.z, k.length_o, wi.z, length_i)) * glossy_terminator(fade, m.ggx_alpha)),
                 scale3(diffuse_part(k, wi.z, length_i), fade));
  value.pdf = div_f(k.specular * (0.5f * d * ggx_visible_share(wo.z, k.length_o)) + k.diffuse * diffuse_pdf(m, wi), k.specular + k.diffuse);
  return bsdf_value_if(valid & (k.specular + k.diffuse > 0.0f), value);
}

EK_FN BsdfValue metallic_roughness_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  return metallic_roughness_value(m, metallic_roughness_terms(m, wo), wo, wi);
}

EK_FN BsdfSample metallic_roughness_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const SpecularOverDiffuse k = metallic_roughness_terms(m, wo);
  const vf p_specular = div_f(k.specular, k.specular + k.diffuse);
  const vi reflect = choice < p_specular;
  const vi mirror = reflect & k.smooth;
  const v3 reflected = normalize3(mirrored(wo, ggx_visible_normal(wo, k.alpha, u, v)));
  vf unused;
  v3 wi = select3(reflect, reflected, diffuse_direction(m, u, v, &unused));
  wi = select3(mirror, V3(-wo.x, -wo.y, wo.z), wi);
  BsdfValue value = metallic_roughness_value(m, k, wo, wi);
  value.f = select3(mirror, surface_reflectance(m, m.f0, m.f90, layer_shares(m), wo.z), value.f);
  value.pdf = (mirror & (wo.z > 0.0f)) ? p_specular : value.pdf;
  return bsdf_sample_of(value, wi, mirror);
}

#endif
