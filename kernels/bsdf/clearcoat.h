// SPDX-License-Identifier: Apache-2.0
// A coat of lacquer on a surface, with a normal of its own [KHR_materials_clearcoat]: a GGX lobe
// that reflects everything, weighted by the coat's Schlick reflectance (index 1.5) at the angle of
// view. The extension leaves the light's angle out of that weight, so a coated material is not
// reciprocal.
//
// The coat and what lies below it may have different normals, and then either has a horizon of its
// own. With EK_HAS_clearcoat_normal, it is therefore here that light is kept from passing the
// surface itself (is_above_coat, is_on_one_side), and not where a coated material is evaluated.
#ifndef EK_BSDF_CLEARCOAT_H
#define EK_BSDF_CLEARCOAT_H
#include "bsdf/fresnel.h"
#include "bsdf/lobe.h"
#include "bsdf/microfacet.h"
#include "bsdf/terminator.h"
#include "lanes/basis.h"

typedef struct {
  vf share;      // of light from wo that the coat reflects; the material below has the rest
  vi smooth;     // the coat is a mirror, which is delta
  GgxAlpha alpha;
  vf length_o;
  Basis basis;   // z is the coat's normal
  v3 wo;         // in that basis
} Coat;

/// clearcoat, alpha  of the material;  normal: local, unit, on wo's side
EK_FN Coat make_coat(vf clearcoat, vf alpha, v3 normal, v3 wo) {
  Coat k;
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  k.basis.x = V3((vf)(1.0f), (vf)(0.0f), (vf)(0.0f));
  k.basis.y = V3((vf)(0.0f), (vf)(1.0f), (vf)(0.0f));
  k.basis.z = up;
  k.wo = wo;
  if (EK_HAS_clearcoat_normal) {
    k.basis = basis_around(normal);
    k.wo = to_local(k.basis, wo);
  }
  k.share = ((k.wo.z > 0.0f) & (wo.z > 0.0f)) ? clearcoat * coat_reflectance(k.wo.z) : (vf)(0.0f);
  k.smooth = alpha < EK_SMOOTH_ALPHA;
  k.alpha = ggx_isotropic(max_f(alpha, (vf)(EK_SMOOTH_ALPHA)));
  k.length_o = ggx_length(k.wo, k.alpha);
  return k;
}

/// Mask of the directions that the coat may reflect to.
/// cos_i  of wi_local with the coat's normal
EK_FN vi is_above_coat(MaterialLanes m, v3 wi_local, vf cos_i) {
#if EK_HAS_clearcoat_normal
  return (cos_i > 0.0f) & (dot3(m.n_geom, wi_local) > 0.0f);
#else
  return cos_i > 0.0f;
#endif
}

/// The terminator's factor of the coat by its own normal.
/// cos_i  as of is_above_coat
EK_FN vf coat_terminator(MaterialLanes m, Coat k, v3 wi_local, vf cos_i) {
#if EK_HAS_clearcoat_normal
  if (!m.has_n_geom) return (vf)(1.0f);
  return glossy_terminator(terminator_factor(dot3(m.n_geom, wi_local), cos_i, dot3(m.n_geom, k.basis.z)), m.clearcoat_alpha);
#else
  (void)k;
  (void)cos_i;
  return glossy_terminator(diffuse_terminator(m, wi_local), m.clearcoat_alpha);
#endif
}

/// Mask of the directions that lie on one side both of the surface itself and of the normal of what
/// is below a coat: others would let light through walls. Set where there is no coat, whose
/// materials others ask (is_on_geometric_side).
EK_FN vi is_on_one_side(MaterialLanes m, v3 wi) {
#if EK_HAS_clearcoat_normal
  const vf cos_geom = dot3(m.n_geom, wi);
  const vi reflected = (cos_geom > 0.0f) & (wi.z > 0.0f);
  const vi transmitted = has_lobe_with(EK_TRAIT_TRANSMITS) ? (cos_geom < 0.0f) & (wi.z < 0.0f) : (vi)(0);
  return (m.clearcoat == 0.0f) | reflected | transmitted;
#else
  (void)m;
  (void)wi;
  return (vi)(-1);
#endif
}

/// eval and pdf of the coat, before it is weighted by `share`.
EK_FN BsdfValue coat_value(MaterialLanes m, Coat k, v3 wi_local) {
  const v3 wi = EK_HAS_clearcoat_normal ? to_local(k.basis, wi_local) : wi_local;
  const v3 sum = add3(k.wo, wi);
  const v3 h = direction_of(sum, dot3(sum, sum));
  const vf d = ggx_d(h, k.alpha);
  BsdfValue value;
  vf f = d * ggx_visibility(k.wo.z, k.length_o, wi.z, ggx_length(wi, k.alpha));
  f = f * coat_terminator(m, k, wi_local, wi.z);
  value.f = V3(f, f, f);
  value.pdf = 0.5f * d * ggx_visible_share(k.wo.z, k.length_o);
  return bsdf_value_if((k.wo.z > 0.0f) & is_above_coat(m, wi_local, wi.z) & !k.smooth, value);
}

/// The direction of a sample. above: is set to the mask of those that do not fail
EK_FN v3 coat_direction(MaterialLanes m, Coat k, vf u, vf v, vi* above) {
  v3 wi = normalize3(mirrored(k.wo, ggx_visible_normal(k.wo, k.alpha, u, v)));
  wi = select3(k.smooth, V3(-k.wo.x, -k.wo.y, k.wo.z), wi);
  const v3 wi_local = EK_HAS_clearcoat_normal ? to_world(k.basis, wi) : wi;
  *above = is_above_coat(m, wi_local, wi.z);
  return wi_local;
}

#endif
