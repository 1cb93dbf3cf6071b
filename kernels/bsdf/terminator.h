// SPDX-License-Identifier: Apache-2.0
// The terminator of shading normals: light ends abruptly at the horizon of the surface itself,
// which the factor here hides.
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

/// terminator_factor of what a diffuse surface of shading normal +z reflects to or from wi. Callers
/// leave transmitted light as it is.
EK_FN vf diffuse_terminator(MaterialLanes m, v3 wi) {
#if EK_USES_GEOMETRIC_NORMAL
  if (!m.has_n_geom) return (vf)(1.0f);
  return terminator_factor(dot3(m.n_geom, wi), wi.z, m.n_geom.z);
#else
  (void)m;
  (void)wi;
  return (vf)(1.0f);
#endif
}

/// The same for a reflection by microfacets: as for a diffuse part where the reflection is as broad
/// (alpha 1), and 1 for a mirror, whose image would only turn black where usable_normal has bent it
/// to the horizon of the surface.
/// diffuse  diffuse_terminator
/// source   Cycles applies its factor to diffuse closures alone (bump_shadowing_term); here there
///          is no step between sharp and rough
EK_FN vf glossy_terminator(vf diffuse, vf alpha) { return (1.0f - alpha) + alpha * diffuse; }

#endif
