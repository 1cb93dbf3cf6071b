// SPDX-License-Identifier: Apache-2.0
// The terminator of shading normals: light ends abruptly at the horizon of the surface itself, which the factor here hides.
#ifndef EK_BSDF_TERMINATOR_H
#define EK_BSDF_TERMINATOR_H
#include "bsdf/lobe.h"

/// Factor in [0, 1] of light that reaches a shading hemisphere from near the horizon of the surface
/// itself, where it would end abruptly; 1 where the two normals are one.
/// cos_geom, cos_shade  of the light's direction with the two normals; the latter positive
/// cos_between          of the two normals
/// source  [Chiang, Li, Burley 2019, "Taming the Shadow Terminator", equation 3]
EK_FN vf terminator_factor(vf cos_geom, vf cos_shade, vf cos_between) {
  const vf ratio = div_f(cos_geom, cos_shade * cos_between);
  const vf bounded = ratio < 1.0f ? ratio : (vf)(1.0f);
  const vf g = bounded > 0.0f ? bounded : (vf)(0.0f);
  return ((g - g * g) + 1.0f) * g;
}

/// The share of terminator_factor that applies to a material, [0, 1]. It is 1 for a diffuse base
/// and for reflections as broad as that, and 0 for sharp reflections of metal and glass: there a
/// mirror image that usable_normal has bent to the horizon of the surface would only turn black.
/// source  Cycles applies its factor to diffuse closures alone (bump_shadowing_term); here there is
///         no step between sharp and rough
EK_FN vf terminator_share(MaterialLanes m) {
  if (!(EK_HAS_metallic_roughness | EK_HAS_transmission | EK_HAS_conductor)) return (vf)(1.0f);
  const vf without_base = m.metallic + (1.0f - m.metallic) * m.transmission;
  return 1.0f - without_base * (1.0f - m.ggx_alpha);
}

/// Factor of light that a part of a material scatters to or from a direction, by the part's own normal: 0 where the direction lies on
/// different sides of the surface itself and of that normal, so that walls leak no light; terminator_factor, as far as `share` says,
/// where it is reflected; 1 where it is transmitted.
/// cosines  as of terminator_factor, but with either sign
EK_FN vf side_factor(vf cos_geom, vf cos_shade, vf cos_between, vf share) {
  const vf hidden = (1.0f - share) + share * terminator_factor(cos_geom, cos_shade, cos_between);
  const vf reflected = ((cos_geom > 0.0f) & (cos_shade > 0.0f)) ? hidden : (vf)(0.0f);
  if (!EK_HAS_transmission) return reflected;
  return ((cos_geom < 0.0f) & (cos_shade < 0.0f)) ? (vf)(1.0f) : reflected;
}

#endif
