// SPDX-License-Identifier: Apache-2.0
// A surface that lets light through [KHR_materials_transmission]: of the dielectric share (1 - metallic) of
// metallic_roughness, `transmission` is glass rather than a layer over a base.
//   thin wall  reflects by Schlick; the rest, times the base colour, goes straight on, spread as the reflection is.
//   diffuse    what of the base KHR_materials_diffuse_transmission says leaves on the other side, as from a sheet of paper; what
//              enters there and what leaves here meet the same layer, so that paths can be reversed.
//   solid      a rough dielectric interface [Walter et al. 2007] with exact Fresnel and Snell [KHR_materials_volume]; each
//              crossing is tinted by the base colour. KHR_materials_specular does not act on it.
// Radiance is what is carried: crossing into a medium of relative index eta divides it by eta^2.
#ifndef EK_BSDF_TRANSMISSION_H
#define EK_BSDF_TRANSMISSION_H
#include "bsdf/metallic_roughness.h"

typedef struct {
  Layers open;     // the share that is no glass
  v3 f0;           // of its layer
  vf f90;
  vf share;        // of the glass
  vf closed;       // of the rest
  vf glass;        // estimated albedo of it
  v3 leak;         // of what the base passes: its f is leak (1 - E(wi))
  vf leaks;        // estimated albedo of it
  vf tint;         // mean of the base colour
  vf eta;          // of solids, 1 where it stands for a mirror
  vi passes_delta; // what the glass transmits is delta
#if EK_HAS_energy_compensation
  GlassPlace place;            // of solids
  vf again;                    // f of light that microfacets of glass pass to each other: on wo's side again glass_loses(wi),
  v3 again_through;            // on the other
  vf returns, crosses;         // their estimated albedos
#endif
} Glass;

/// Reflectance of the glass; cos_h: of wo with the microfacet.
EK_FN v3 glass_reflectance(MaterialLanes m, vf cos_h) {
  const vf exact = fresnel_dielectric(cos_h, m.eta);
  v3 f = select3(m.solid, V3(exact, exact, exact), schlick(m.f0_dielectric, m.specular, schlick_weight(cos_h)));
#if EK_HAS_iridescence
  // From inside of a solid as from outside along the refracted direction: what a film reflects is the same both ways.
  const vi some = (m.iridescence > 0.0f) & !(m.solid & (fresnel_is_mirror(m.eta) | (m.eta == 1.0f)));
  if (ANY(some)) {
    const vf outside2 = 1.0f - ((1.0f - cos_h) * (1.0f + cos_h)) / (m.eta * m.eta);
    const vi inside = m.solid & (m.eta < 1.0f);
    const vf cosine = inside ? sqrt(max_f(outside2, (vf)(0.0f))) : cos_h;
    const vf r = (m.eta - 1.0f) / (m.eta + 1.0f), f0 = r * r;
    const v3 under = with_film(m, f, select3(m.solid, V3(f0, f0, f0), m.f0_dielectric), min_f(max_f(cosine, (vf)(0.0f)), (vf)(1.0f)));
    f = select3(some & !(inside & (outside2 <= 0.0f)), under, f);
  }
#endif
  return f;
}

// Some light leaves to the other side as from a diffuse surface.
#define EK_LEAKS (EK_HAS_diffuse_transmission | EK_HAS_energy_compensation)

#if EK_HAS_energy_compensation
// What glass under a film reflects of an even light in the thinner medium.
EK_FN vf filmy_glass_mean_reflectance(MaterialLanes m, Glass g) {
  vf mean = (vf)(0.0f);
#if EK_HAS_iridescence
  m.eta = max_f(g.eta, 1.0f / g.eta);
  for (uint i = 0; i < EK_FILM_NODES; ++i)
    mean = mean + film_weights[i] * mean_component(glass_reflectance(m, (vf)(film_cosines[i])));
#endif
  return mean;
}

// What the glass of g loses along a direction of cosine c, on wo's side or the other one.
EK_FN vf glass_loses_along(MaterialLanes m, Glass g, vi other_side, vf c, vf length) {
  vf lost = mirrors_lose(g.open.alpha, c, length);  // a thin wall reflects and passes in one lobe
  if (ANY(m.solid)) {
    const vf solid = glass_loses(g.place, other_side ? g.place.there : g.place.here, glass_alpha(g.open.alpha), c);
    lost = m.solid ? solid : lost;
  }
  return lost;
}

// Light that single scattering loses leaves on either side in lobes of what the directions there lose. How much crosses is free but for
// reciprocity: with n the index of the inside, (1 - r_out) / (lost_in n^2) = (1 - r_in) / lost_out, and as much as leaves of an even light
// at the surface itself, as far as both r are then in [0, 1].
EK_FN Glass with_glass_again(MaterialLanes m, Glass g, v3 wo) {
  g.place = glass_place(g.eta);
  const vi none = g.open.smooth | g.passes_delta | (m.solid & fresnel_is_mirror(m.eta));
  const vf lost = glass_loses_along(m, g, (vi)(0), wo.z, g.open.length_o);
  vf here = mirrors_lose_mean(g.open.alpha), there = here;
  const v3 f = schlick(m.f0_dielectric, m.specular, (vf)(1.0f / 21.0f));
  const vi filmy = EK_HAS_iridescence ? m.iridescence > 0.0f : (vi)(0);
  const vf reflects_film = ANY(filmy) ? filmy_glass_mean_reflectance(m, g) : (vf)(0.0f);
  vf crosses_here = 1.0f - (filmy ? reflects_film : mean_component(f)), crosses_there = crosses_here;
  if (ANY(m.solid)) {
    const vf solid_here = glass_loses_mean(g.place, g.place.here, glass_alpha(g.open.alpha)), solid_there = glass_loses_mean(g.place, g.place.there, glass_alpha(g.open.alpha));
    const vf n = max_f(g.eta, 1.0f / g.eta), n2 = n * n;
    // The reflectance of an even light from outside, by Kulla and Conty's fit; what is lost is the table's also under a film.
    const vf reflects = (n - 1.0f) / (4.08567f + 1.00071f * n), passes = 1.0f - (filmy ? reflects_film : reflects);
    const vf scale = passes / (n2 * max_f(max_f(solid_here, solid_there), (vf)(0x1p-30f)));
    const vi outside = g.eta > 1.0f;
    here = m.solid ? solid_here : here;
    there = m.solid ? solid_there : there;
    crosses_here = m.solid ? scale * there * (outside ? n2 : (vf)(1.0f)) : crosses_here;
    crosses_there = m.solid ? scale * here * (outside ? (vf)(1.0f) : n2) : crosses_there;
  }
  const vf share = none ? (vf)(0.0f) : g.share * lost;
  const vf spread = share * EK_INV_PI / max_f(here, (vf)(0x1p-30f));
  g.again = spread * (1.0f - crosses_here);
  g.again_through = scale3(m.base_color, spread * crosses_there);
  g.returns = share * (1.0f - crosses_here);
  g.crosses = (share * crosses_here) * g.tint;
  return g;
}
#endif

/// The probability of reflecting rather than transmitting, at a microfacet of mean reflectance f: by what leaves either way.
EK_FN vf glass_reflects(vf f, vf tint) {
  const vf all = f + (1.0f - f) * tint;
  return all > 0.0f ? f / all : (vf)(1.0f);
}

EK_FN Glass make_glass(MaterialLanes m, v3 wo) {
  Glass g;
  const vf dielectric = 1.0f - m.metallic;
  const vf opaque = dielectric * (1.0f - m.transmission);
  g.share = dielectric * m.transmission;
  g.closed = m.metallic + opaque;
  g.f0 = add3(scale3(m.base_color, m.metallic), scale3(m.f0_dielectric, opaque));
  g.f90 = m.metallic + opaque * m.specular;
  vf reflects = opaque;
  if (EK_HAS_diffuse_transmission) reflects = opaque * (1.0f - m.diffuse_transmission);
  g.open = make_layers(m, wo, g.f0, g.f90, g.closed, scale3(m.base_color, reflects));
  if (EK_HAS_diffuse_transmission) {
    g.leak = scale3(m.diffuse_transmission_color, (opaque * m.diffuse_transmission) * g.open.enters);
    g.leaks = mean_component(m.diffuse_transmission_color) * (opaque * m.diffuse_transmission) * g.open.kept;
  }
  g.tint = mean_component(m.base_color);
  const vf f = mean_component(glass_reflectance(m, wo.z));
  g.glass = g.share * max_f(f + (1.0f - f) * g.tint, (vf)(0x1p-6f));
  g.eta = fresnel_is_mirror(m.eta) ? (vf)(1.0f) : m.eta;
  // Refraction turns a microfacet's slope into an angle (eta - 1) times as large, eta of the denser side: as narrow as a smooth
  // mirror's lobe, it is delta, from both sides.
  const vf bend = abs_f(g.eta - 1.0f) / min_f(g.eta, (vf)(1.0f));
  g.passes_delta = g.open.smooth | (m.solid & (g.open.alpha.x * bend < EK_SMOOTH_ALPHA));
#if EK_HAS_energy_compensation
  if (!EK_HAS_diffuse_transmission) g.leaks = (vf)(0.0f);
  g = with_glass_again(m, g, wo);
  g.open.diffuse = g.open.diffuse + g.returns;
  g.leaks = g.leaks + g.crosses;
#endif
  return g;
}

// Sum of the estimated albedos.
EK_FN vf glass_total(Glass g) {
  const vf total = (g.open.specular + g.open.diffuse) + g.glass;
  return EK_LEAKS ? total + g.leaks : total;
}

EK_FN BsdfValue transmission_value(MaterialLanes m, Glass g, v3 wo, v3 wi) {
  const vi below = wi.z < 0.0f;
  const vi refracts = below & m.solid;
  const v3 wi_above = V3(wi.x, wi.y, abs_f(wi.z));
  const vf cos_i = wi_above.z;
  // The half vector of reflection; that of refraction [Walter et al. 2007, eq. 16] points away from the denser side.
  v3 sum = add3(wo, select3(refracts, scale3(wi, g.eta), wi_above));
  sum = select3(sum.z < 0.0f, neg3(sum), sum);
  const vf sum2 = dot3(sum, sum);
  const v3 h = direction_of(sum, sum2);
  const vf cos_o_h = refracts ? dot3(wo, h) : 0.5f * sqrt(sum2);
  const vf cos_i_h = dot3(wi, h);  // of refraction, negative
  const vf length_i = ggx_length(wi_above, g.open.alpha);
  const vf d_any = ggx_d(h, g.open.alpha);
  const vf d = (below ? g.passes_delta : g.open.smooth) ? (vf)(0.0f) : d_any;
  const vf visible = 0.5f * d * ggx_visible_share(wo.z, g.open.length_o);  // density of a reflection
  const vf spread = d * ggx_visibility(wo.z, g.open.length_o, cos_i, length_i);

  const v3 f = glass_reflectance(m, max_f(cos_o_h, (vf)(0.0f)));
  const vf p_reflect = glass_reflects(mean_component(f), g.tint);
  const v3 layer = surface_reflectance(m, g.f0, g.f90, g.closed, cos_o_h);
  const vf total = glass_total(g);
  BsdfValue above;
  above.f = add3(scale3(add3(layer, scale3(f, g.share)), spread), layers_diffuse(g.open, cos_i, length_i));
#if EK_HAS_energy_compensation
  const vf lost = glass_loses_along(m, g, below, cos_i, length_i) * cos_i;
  above.f = add3(above.f, V3(g.again * lost, g.again * lost, g.again * lost));
#endif
  above.pdf = ((g.open.specular + g.glass * p_reflect) * visible + g.open.diffuse * (EK_INV_PI * cos_i)) / total;

  // [Walter et al. 2007, eq. 21 and 17] over eta^2: there n_i, n_o are of the light's and the viewer's side, and the
  // denominator (n_i cos_i_h + n_o cos_o_h)^2 is n_o^2 |sum|^2. Shadowing is separable, eq. 23.
  const vf jacobian = abs_f(cos_i_h) / max_f(sum2, (vf)(0x1p-60f));
  const vf refracted = (cos_o_h * jacobian) * (d * cos_i * 4.0f) /
                       ((wo.z + g.open.length_o) * (cos_i + length_i));
  const vi possible = (cos_o_h > 0.0f) & (cos_i_h < 0.0f);
  const vf passed = m.solid ? (possible ? refracted : (vf)(0.0f)) : spread;
  const vf passed_pdf = m.solid ? (possible ? (4.0f * visible) * cos_o_h * (g.eta * g.eta) * jacobian : (vf)(0.0f)) : visible;
  BsdfValue through;
  through.f = scale3(mul3(m.base_color, V3(1.0f - f.x, 1.0f - f.y, 1.0f - f.z)), g.share * passed);
  through.pdf = (g.glass * (1.0f - p_reflect)) * passed_pdf / total;
  if (EK_HAS_diffuse_transmission) through.f = add3(through.f, scale3(g.leak, layers_let_out(g.open, cos_i, length_i) * cos_i));
#if EK_HAS_energy_compensation
  through.f = add3(through.f, scale3(g.again_through, lost));
#endif
  if (EK_LEAKS) through.pdf = through.pdf + g.leaks * (EK_INV_PI * cos_i) / total;

  BsdfValue value = {select3(below, through.f, above.f), below ? through.pdf : above.pdf};
  return bsdf_value_if((wo.z > 0.0f) & (wi.z != 0.0f) & (total > 0.0f), value);
}

EK_FN BsdfValue transmission_evaluate(MaterialLanes m, v3 wo, v3 wi) {
  return transmission_value(m, make_glass(m, wo), wo, wi);
}

EK_FN BsdfSample transmission_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const Glass g = make_glass(m, wo);
  const vf total = glass_total(g);
  const vf p_layer = g.open.specular / total, p_base = g.open.diffuse / total, p_glass = g.glass / total;
  const vi from_base = (choice >= p_layer) & (choice < p_layer + p_base);
  vi from_glass = (choice >= p_layer + p_base) & (p_glass > 0.0f);
  vf rest = (choice - (p_layer + p_base)) / p_glass;
  vi from_leak = (vi)(0);
  if (EK_LEAKS) {  // after the base, before the glass
    const vf p_leak = g.leaks / total, p_before = (p_layer + p_base) + p_leak;
    from_leak = (choice >= p_layer + p_base) & ((choice < p_before) | !from_glass) & (p_leak > 0.0f);
    from_glass = from_glass & !from_leak;
    rest = max_f(choice - p_before, (vf)(0.0f)) / p_glass;
  }

  v3 h = normalize3(ggx_visible_normal(wo, g.open.alpha, u, v));
  h = select3(g.open.smooth, V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), h);
  const vf cos_h = dot3(wo, h);
  const v3 f = glass_reflectance(m, cos_h);
  const vf p_reflect = glass_reflects(mean_component(f), g.tint);
  const vi passes = from_glass & (rest >= p_reflect);
  const vi from_layer = !(from_base | from_leak) & !passes;

  const v3 reflected = normalize3(mirrored(wo, h));
  v3 wi = select3(from_base, warp_cosine_hemisphere(u, v), reflected);
  wi = select3(passes & !m.solid, V3(wi.x, wi.y, -wi.z), wi);
  wi = select3(passes & m.solid, normalize3(refract(wo, h, cos_h, g.eta)), wi);
  // Delta directions exactly. Through an interface that hardly bends light, a rough one too, the path is that of the surface
  // itself, while the share that passes is the microfacet's.
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  const vi mirror = from_layer & g.open.smooth;
  const vi straight = passes & g.passes_delta;
  wi = select3(mirror, V3(-wo.x, -wo.y, wo.z), wi);
  wi = select3(straight & !m.solid, neg3(wo), wi);
  wi = select3(straight & m.solid, refract(wo, up, wo.z, g.eta), wi);
  if (EK_LEAKS) wi = select3(from_leak, neg3(warp_cosine_hemisphere(u, v)), wi);

  BsdfValue value = transmission_value(m, g, wo, wi);
  const v3 layer = surface_reflectance(m, g.f0, g.f90, g.closed, wo.z);
  value.f = select3(mirror, add3(layer, scale3(f, g.share)), value.f);
  value.pdf = mirror ? p_layer + p_glass * p_reflect : value.pdf;
  const v3 kept = mul3(m.base_color, V3(1.0f - f.x, 1.0f - f.y, 1.0f - f.z));
  value.f = select3(straight, scale3(kept, g.share / (m.solid ? g.eta * g.eta : (vf)(1.0f))), value.f);
  value.pdf = straight ? p_glass * (1.0f - p_reflect) : value.pdf;
  // A reflection below the surface, or a refraction above it, is lost.
  const vi valid = (wo.z > 0.0f) & (total > 0.0f) & ((passes | from_leak) ? wi.z < 0.0f : wi.z > 0.0f);
  return bsdf_sample_of(bsdf_value_if(valid, value), wi, mirror | straight);
}

/// What a path inside this solid gets back when it leaves: the square of the solid's index, by which radiance was divided when
/// it entered. 1 for a path that goes on outside. front: the surface was met from outside; transmitted: the path crosses it.
EK_FN vf radiance_returned_outside(MaterialLanes m, vi front, vi transmitted) {
  const vi inside = m.solid & !fresnel_is_mirror(m.eta) & (front ? transmitted : !transmitted);
  const vf index = front ? m.eta : (vf)(1.0f) / m.eta;
  return inside ? index * index : (vf)(1.0f);
}

#endif
