// SPDX-License-Identifier: Apache-2.0
// A transmissive surface [KHR_materials_transmission]: of the dielectric share (1 - metallic) of
// metallic_roughness, `transmission` is glass instead of a specular layer over a diffuse base.
//   thin wall  Reflects by Schlick. The rest, times the base colour, goes straight on, and is as
//              rough as the reflection.
//   diffuse    A share of the base [KHR_materials_diffuse_transmission] leaves on the other side,
//              as from a sheet of paper. Light meets the same specular layer on both sides, so that
//              paths can be reversed.
//   solid      A rough dielectric interface [Walter et al. 2007] with exact Fresnel and Snell
//              [KHR_materials_volume]. Each crossing is tinted by the base colour.
//              KHR_materials_specular changes how much it reflects, and not how it refracts.
// Paths carry radiance: crossing into a medium of relative index eta divides it by eta^2.
#ifndef EK_BSDF_TRANSMISSION_H
#define EK_BSDF_TRANSMISSION_H
#include "bsdf/lobe.h"
#include "bsdf/metallic_roughness.h"

typedef struct {
  SpecularOverDiffuse base;  // the share of the surface that is not glass
  v3 f0;            // of its specular layer
  vf f90;
  vf share;         // of the glass
  LayerShares shares;  // of the rest
  vf glass_albedo;  // estimated albedo of the glass
  v3 diffuse_transmission;         // f of diffuse transmission is this times 1 - E(wi)
  vf diffuse_transmission_albedo;  // its estimated albedo, with that of ms_transmission
  vf tint;          // mean of the base colour
  vf eta;           // of solids; 1 where the index stands for a mirror
  vi is_specular;   // the transmission of the glass is delta
#if EK_HAS_energy_compensation
  GlassTable table; // of solids
  vf ms_reflection;    // f of multiple scattering is this times glass_one_minus_E(wi) on wo's side,
  v3 ms_transmission;  // and this times glass_one_minus_E(wi) on the other
  vf ms_reflection_albedo, ms_transmission_albedo;  // their estimated albedos
#endif
} Glass;

// Reflectance at normal incidence of the two indices alone; NaN where one stands for a mirror.
EK_FN vf solid_f0(vf eta) {
  const vf r = div_f(eta - 1.0f, eta + 1.0f);
  return r * r;
}

/// Reflectance of a solid: m.f0_dielectric at normal incidence and m.specular at grazing angles,
/// and between the two as Fresnel's equations for its indices are between theirs. So it is the same
/// from both sides. Total reflection stays total.
/// exact  by Fresnel's equations
EK_FN v3 solid_reflectance(MaterialLanes m, vf exact, vf cos_h) {
#if EK_HAS_solid_specular
  const vi mirror = fresnel_is_mirror(m.eta);
  const vf f0 = solid_f0(m.eta);
  const v3 f = schlick(m.f0_dielectric, m.specular, mirror ? schlick_weight(cos_h) : div_f(exact - f0, 1.0f - f0));
  const vi total = !mirror & (exact >= 1.0f);
  const vf none = (vf)(0.0f), all = (vf)(1.0f);
  return select3(total, V3(all, all, all), V3(max_f(f.x, none), max_f(f.y, none), max_f(f.z, none)));
#else
  (void)m;
  (void)cos_h;
  return V3(exact, exact, exact);
#endif
}

/// Reflectance of the glass.
/// cos_h  cosine of wo with the microfacet
EK_FN v3 glass_reflectance(MaterialLanes m, vf cos_h) {
  const v3 of_solid = solid_reflectance(m, fresnel_dielectric(cos_h, m.eta), cos_h);
  v3 f = select3(m.solid, of_solid, schlick(m.f0_dielectric, m.specular, schlick_weight(cos_h)));
#if EK_HAS_iridescence
  // A film reflects the same from inside of a solid as from outside along the refracted direction.
  const vi some = (m.iridescence > 0.0f) & !(m.solid & (fresnel_is_mirror(m.eta) | (m.eta == 1.0f)));
  if (ANY(some)) {
    const vf outside2 = 1.0f - div_f((1.0f - cos_h) * (1.0f + cos_h), m.eta * m.eta);
    const vi inside = m.solid & (m.eta < 1.0f);
    const vf cosine = inside ? sqrt_f(max_f(outside2, (vf)(0.0f))) : cos_h;
    const vf of_indices = solid_f0(m.eta);
    const v3 f0 = EK_HAS_solid_specular ? m.f0_dielectric : select3(m.solid, V3(of_indices, of_indices, of_indices), m.f0_dielectric);
    const v3 with_film = with_thin_film(m, f, f0, min_f(max_f(cosine, (vf)(0.0f)), (vf)(1.0f)));
    f = select3(some & !(inside & (outside2 <= 0.0f)), with_film, f);
  }
#endif
  return f;
}

// Some light leaves on the other side as from a diffuse surface.
#define EK_TRANSMITS_DIFFUSELY (EK_HAS_diffuse_transmission | EK_HAS_energy_compensation)

#if EK_HAS_energy_compensation
// Reflectance of glass under a film for uniform light from the medium of lower index.
EK_FN vf thin_film_glass_mean_reflectance(MaterialLanes m, Glass g) {
  vf mean = (vf)(0.0f);
#if EK_HAS_iridescence
  m.eta = max_f(g.eta, div_f(1.0f, g.eta));
  for (uint i = 0; i < EK_THIN_FILM_NODES; ++i)
    mean = mean + thin_film_weights[i] * mean_component(glass_reflectance(m, (vf)(thin_film_cosines[i])));
#endif
  return mean;
}

// 1 - E of the glass for a direction of cosine c, on wo's side or on the other one.
EK_FN vf glass_one_minus_E_along(MaterialLanes m, Glass g, vi other_side, vf c, vf length) {
  vf one_minus = one_minus_E(g.base.alpha, c, length);  // a thin wall reflects and transmits in one lobe
  if (ANY(m.solid)) {
    const vf solid = glass_one_minus_E(g.table, other_side ? g.table.there : g.table.here, glass_alpha(g.base.alpha), c);
    one_minus = m.solid ? solid : one_minus;
  }
  return one_minus;
}

// Adds the light that single scattering loses: it leaves on both sides in lobes proportional to 1 -
// E of the directions there. Reciprocity alone restricts how much crosses: with n the index of the
// inside, r the share that stays and l = 1 - E_avg, (1 - r_out) / (l_in n^2) = (1 - r_in) / l_out.
// We take as much as crosses of uniform light at the interface itself, as far as both r are then in
// [0, 1].
EK_FN Glass with_multiple_scattering(MaterialLanes m, Glass g, v3 wo) {
  g.table = glass_table(g.eta);
  const vi none = g.base.smooth | g.is_specular | (m.solid & fresnel_is_mirror(m.eta));
  const vf one_minus_E_o = glass_one_minus_E_along(m, g, (vi)(0), wo.z, g.base.length_o);
  vf here = one_minus_E_avg(g.base.alpha), there = here;
  const v3 f = schlick(m.f0_dielectric, m.specular, (vf)(1.0f / 21.0f));
  const vi has_film = EK_HAS_iridescence ? m.iridescence > 0.0f : (vi)(0);
  const vf reflects_film = ANY(has_film) ? thin_film_glass_mean_reflectance(m, g) : (vf)(0.0f);
  vf crosses_here = 1.0f - (has_film ? reflects_film : mean_component(f)), crosses_there = crosses_here;
  if (ANY(m.solid)) {
    const vf solid_here = glass_one_minus_E_avg(g.table, g.table.here, glass_alpha(g.base.alpha)), solid_there = glass_one_minus_E_avg(g.table, g.table.there, glass_alpha(g.base.alpha));
    const vf n = max_f(g.eta, div_f(1.0f, g.eta)), n2 = n * n;
    // Reflectance for uniform light from outside [Kulla and Conty 2017]; the loss is the table's,
    // under a film and with KHR_materials_specular too.
    vf reflects = div_f(n - 1.0f, 4.08567f + 1.00071f * n);
    if (EK_HAS_solid_specular) reflects = mean_component(solid_reflectance(m, reflects, (vf)(0.0f)));
    const vf transmits = 1.0f - (has_film ? reflects_film : reflects);
    const vf scale = div_f(transmits, n2 * max_f(max_f(solid_here, solid_there), (vf)(0x1p-30f)));
    const vi outside = g.eta > 1.0f;
    here = m.solid ? solid_here : here;
    there = m.solid ? solid_there : there;
    crosses_here = m.solid ? scale * there * (outside ? n2 : (vf)(1.0f)) : crosses_here;
    crosses_there = m.solid ? scale * here * (outside ? (vf)(1.0f) : n2) : crosses_there;
  }
  const vf share = none ? (vf)(0.0f) : g.share * one_minus_E_o;
  const vf spread = div_f(share * EK_INV_PI, max_f(here, (vf)(0x1p-30f)));
  g.ms_reflection = spread * (1.0f - crosses_here);
  g.ms_transmission = scale3(m.base_color, spread * crosses_there);
  g.ms_reflection_albedo = share * (1.0f - crosses_here);
  g.ms_transmission_albedo = (share * crosses_here) * g.tint;
  return g;
}
#endif

/// Probability of reflecting at a microfacet of mean reflectance f, by the light that leaves either
/// way.
EK_FN vf glass_reflects(vf f, vf tint) {
  const vf all = f + (1.0f - f) * tint;
  return all > 0.0f ? div_f(f, all) : (vf)(1.0f);
}

EK_FN Glass make_glass(MaterialLanes m, v3 wo) {
  Glass g;
  const vf dielectric = 1.0f - m.metallic;
  const vf opaque = dielectric * (1.0f - m.transmission);
  g.share = dielectric * m.transmission;
  g.shares.metal = m.metallic;
  g.shares.dielectric = opaque;
  g.f0 = add3(scale3(m.base_color, m.metallic), scale3(m.f0_dielectric, opaque));
  g.f90 = m.metallic + opaque * m.specular;
  vf reflects = opaque;
  if (EK_HAS_diffuse_transmission) reflects = opaque * (1.0f - m.diffuse_transmission);
  g.base = make_specular_over_diffuse(m, wo, g.f0, g.f90, g.shares, scale3(m.base_color, reflects));
  if (EK_HAS_diffuse_transmission) {
    g.diffuse_transmission = scale3(m.diffuse_transmission_color, (opaque * m.diffuse_transmission) * g.base.base_scale);
    g.diffuse_transmission_albedo = mean_component(m.diffuse_transmission_color) * (opaque * m.diffuse_transmission) * g.base.one_minus_albedo_o;
  }
  g.tint = mean_component(m.base_color);
  const vf f = mean_component(glass_reflectance(m, wo.z));
  g.glass_albedo = g.share * max_f(f + (1.0f - f) * g.tint, (vf)(0x1p-6f));
  g.eta = fresnel_is_mirror(m.eta) ? (vf)(1.0f) : m.eta;
  // Refraction turns a microfacet's slope into an angle (eta - 1) times as large, with eta of the
  // denser side. A lobe as narrow as a smooth mirror's counts as delta, from both sides.
  const vf bend = div_f(abs_f(g.eta - 1.0f), min_f(g.eta, (vf)(1.0f)));
  g.is_specular = g.base.smooth | (m.solid & (g.base.alpha.x * bend < EK_SMOOTH_ALPHA));
#if EK_HAS_energy_compensation
  if (!EK_HAS_diffuse_transmission) g.diffuse_transmission_albedo = (vf)(0.0f);
  g = with_multiple_scattering(m, g, wo);
  g.base.diffuse = g.base.diffuse + g.ms_reflection_albedo;
  g.diffuse_transmission_albedo = g.diffuse_transmission_albedo + g.ms_transmission_albedo;
#endif
  return g;
}

// Sum of the estimated albedos, which choices of a part are made by.
EK_FN vf glass_total(Glass g) {
  const vf total = (g.base.specular + g.base.diffuse) + g.glass_albedo;
  return EK_TRANSMITS_DIFFUSELY ? total + g.diffuse_transmission_albedo : total;
}

EK_FN BsdfValue transmission_value(MaterialLanes m, Glass g, v3 wo, v3 wi) {
  const vf fade = diffuse_terminator(m, wi);  // here, since behind the rest it costs a GPU four registers more
  const vi below = wi.z < 0.0f;
  const vi refracts = below & m.solid;
  const v3 wi_above = V3(wi.x, wi.y, abs_f(wi.z));
  const vf cos_i = wi_above.z;
  // The half vector of reflection, or that of refraction, which points away from the denser side
  // [Walter et al. 2007, eq. 16].
  v3 sum = add3(wo, select3(refracts, scale3(wi, g.eta), wi_above));
  sum = select3(sum.z < 0.0f, neg3(sum), sum);
  const vf sum2 = dot3(sum, sum);
  const v3 h = direction_of(sum, sum2);
  const vf cos_o_h = refracts ? dot3(wo, h) : 0.5f * sqrt_f(sum2);
  const vf cos_i_h = dot3(wi, h);  // negative for refraction
  const vf length_i = ggx_length(wi_above, g.base.alpha);
  const vf d_any = ggx_d(h, g.base.alpha);
  const vf d = (below ? g.is_specular : g.base.smooth) ? (vf)(0.0f) : d_any;
  const vf visible = 0.5f * d * ggx_visible_share(wo.z, g.base.length_o);  // pdf of reflection
  const vf spread = d * ggx_visibility(wo.z, g.base.length_o, cos_i, length_i);

  const v3 f = glass_reflectance(m, max_f(cos_o_h, (vf)(0.0f)));
  const vf p_reflect = glass_reflects(mean_component(f), g.tint);
  const v3 layer = surface_reflectance(m, g.f0, g.f90, g.shares, cos_o_h);
  const vf total = glass_total(g);
  BsdfValue above;
  above.f = add3(scale3(add3(layer, scale3(f, g.share)), spread * glossy_terminator(fade, m.ggx_alpha)),
                 scale3(diffuse_part(g.base, cos_i, length_i), fade));
#if EK_HAS_energy_compensation
  const vf one_minus_E_cos_i = glass_one_minus_E_along(m, g, below, cos_i, length_i) * cos_i;
  const vf ms_reflected = (g.ms_reflection * one_minus_E_cos_i) * fade;
  above.f = add3(above.f, V3(ms_reflected, ms_reflected, ms_reflected));
#endif
  above.pdf = div_f((g.base.specular + g.glass_albedo * p_reflect) * visible + g.base.diffuse * (EK_INV_PI * cos_i), total);

  // This is [Walter et al. 2007, eq. 21 and 17] over eta^2: n_i and n_o belong to the light's and
  // the viewer's side, and the denominator (n_i cos_i_h + n_o cos_o_h)^2 is n_o^2 |sum|^2.
  // Shadowing is separable [eq. 23].
  const vf jacobian = div_f(abs_f(cos_i_h), max_f(sum2, (vf)(0x1p-60f)));
  const vf refracted = div_f((cos_o_h * jacobian) * (d * cos_i * 4.0f), (wo.z + g.base.length_o) * (cos_i + length_i));
  const vi possible = (cos_o_h > 0.0f) & (cos_i_h < 0.0f);
  const vf passed = m.solid ? (possible ? refracted : (vf)(0.0f)) : spread;
  const vf passed_pdf = m.solid ? (possible ? (4.0f * visible) * cos_o_h * (g.eta * g.eta) * jacobian : (vf)(0.0f)) : visible;
  BsdfValue through;
  through.f = scale3(mul3(m.base_color, V3(1.0f - f.x, 1.0f - f.y, 1.0f - f.z)), g.share * passed);
  through.pdf = div_f((g.glass_albedo * (1.0f - p_reflect)) * passed_pdf, total);
  if (EK_HAS_diffuse_transmission) through.f = add3(through.f, scale3(g.diffuse_transmission, one_minus_albedo(g.base, cos_i, length_i) * cos_i));
#if EK_HAS_energy_compensation
  through.f = add3(through.f, scale3(g.ms_transmission, one_minus_E_cos_i));
#endif
  if (EK_TRANSMITS_DIFFUSELY) through.pdf = through.pdf + div_f(g.diffuse_transmission_albedo * (EK_INV_PI * cos_i), total);

  BsdfValue value = {select3(below, through.f, above.f), below ? through.pdf : above.pdf};
  return bsdf_value_if((wo.z > 0.0f) & (wi.z != 0.0f) & (total > 0.0f), value);
}

EK_FN BsdfValue transmission_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  return transmission_value(m, make_glass(m, wo), wo, wi);
}

EK_FN BsdfSample transmission_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const Glass g = make_glass(m, wo);
  const vf total = glass_total(g);
  const vf p_layer = div_f(g.base.specular, total), p_base = div_f(g.base.diffuse, total), p_glass = div_f(g.glass_albedo, total);
  const vi from_base = (choice >= p_layer) & (choice < p_layer + p_base);
  vi from_glass = (choice >= p_layer + p_base) & (p_glass > 0.0f);
  vf rest = div_f(choice - (p_layer + p_base), p_glass);
  vi from_diffuse_transmission = (vi)(0);
  if (EK_TRANSMITS_DIFFUSELY) {  // its range of `choice` is between base and glass
    const vf p_diffuse_transmission = div_f(g.diffuse_transmission_albedo, total), p_before = (p_layer + p_base) + p_diffuse_transmission;
    from_diffuse_transmission = (choice >= p_layer + p_base) & ((choice < p_before) | !from_glass) & (p_diffuse_transmission > 0.0f);
    from_glass = from_glass & !from_diffuse_transmission;
    rest = div_f(max_f(choice - p_before, (vf)(0.0f)), p_glass);
  }

  v3 h = normalize3(ggx_visible_normal(wo, g.base.alpha, u, v));
  h = select3(g.base.smooth, V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), h);
  const vf cos_h = dot3(wo, h);
  const v3 f = glass_reflectance(m, cos_h);
  const vf p_reflect = glass_reflects(mean_component(f), g.tint);
  const vi transmits = from_glass & (rest >= p_reflect);
  const vi from_layer = !(from_base | from_diffuse_transmission) & !transmits;

  const v3 reflected = normalize3(mirrored(wo, h));
  v3 wi = select3(from_base, warp_cosine_hemisphere(u, v), reflected);
  wi = select3(transmits & !m.solid, V3(wi.x, wi.y, -wi.z), wi);
  wi = select3(transmits & m.solid, normalize3(refract(wo, h, cos_h, g.eta)), wi);
  // Delta directions are exact. Where a rough interface hardly bends light, the direction is that
  // of the surface itself, while the transmitted share is the microfacet's.
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  const vi mirror = from_layer & g.base.smooth;
  const vi specular_transmission = transmits & g.is_specular;
  wi = select3(mirror, V3(-wo.x, -wo.y, wo.z), wi);
  wi = select3(specular_transmission & !m.solid, neg3(wo), wi);
  wi = select3(specular_transmission & m.solid, refract(wo, up, wo.z, g.eta), wi);
  if (EK_TRANSMITS_DIFFUSELY) wi = select3(from_diffuse_transmission, neg3(warp_cosine_hemisphere(u, v)), wi);

  BsdfValue value = transmission_value(m, g, wo, wi);
  const v3 layer = surface_reflectance(m, g.f0, g.f90, g.shares, wo.z);
  value.f = select3(mirror, add3(layer, scale3(f, g.share)), value.f);
  value.pdf = mirror ? p_layer + p_glass * p_reflect : value.pdf;
  const v3 transmitted = mul3(m.base_color, V3(1.0f - f.x, 1.0f - f.y, 1.0f - f.z));
  value.f = select3(specular_transmission, scale3(transmitted, div_f(g.share, m.solid ? g.eta * g.eta : (vf)(1.0f))), value.f);
  value.pdf = specular_transmission ? p_glass * (1.0f - p_reflect) : value.pdf;
  // A reflection to below the surface or a refraction to above it is lost.
  const vi valid = (wo.z > 0.0f) & (total > 0.0f) & ((transmits | from_diffuse_transmission) ? wi.z < 0.0f : wi.z > 0.0f);
  return bsdf_sample_of(bsdf_value_if(valid, value), wi, mirror | specular_transmission);
}

/// The factor of a path's throughput where it crosses the boundary of a solid: radiance over the
/// square of the index of refraction stays the same. 1 where the index stands for a mirror.
EK_FN vf radiance_transmitted(MaterialLanes m) {
  return fresnel_is_mirror(m.eta) ? (vf)(1.0f) : div_f((vf)(1.0f), m.eta * m.eta);
}

/// The factor of radiance between this solid and the outside: the square of the solid's index, by
/// which radiance was divided when the path entered. 1 for a path that goes on outside.
/// front        mask: the surface was met from outside
/// transmitted  mask: the path crosses it
EK_FN vf radiance_returned_outside(MaterialLanes m, vi front, vi transmitted) {
  const vi inside = m.solid & !fresnel_is_mirror(m.eta) & (front ? transmitted : !transmitted);
  const vf index = front ? m.eta : div_f((vf)(1.0f), m.eta);
  return inside ? index * index : (vf)(1.0f);
}

#endif
