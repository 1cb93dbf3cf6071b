// SPDX-License-Identifier: Apache-2.0
// Densities with which directions are chosen, and the weight of one way to find light against
// another.
#ifndef EK_DENSITY_H
#define EK_DENSITY_H
#include "lanes/math.h"

// PathState.pdf where the direction of a path has no density: of camera rays, of null interfaces,
// and after delta scattering. Light sampling does not find what such a path meets, so emission
// counts in full.
#define EK_NO_DENSITY (-1.0f)
/// Masks of the paths whose direction has a density, and of those where it has none.
/// pdf  PathState.pdf
EK_FN vi has_density(vf pdf) { return pdf >= 0.0f; }
EK_FN vi has_no_density(vf pdf) { return pdf < 0.0f; }

/// Weight of a strategy of density a against another of density b [Veach 1995, the power heuristic
/// with exponent 2]. In [0, 1], and the two weights add to 1, whatever the densities are: huge,
/// both zero, infinite.
EK_FN vf power_heuristic(vf a, vf b) {
  vf ratio = div_f(b, a);
  ratio = ratio == ratio ? ratio : (vf)(1.0f);  // 0 / 0, inf / inf: no preference
  return div_f(1.0f, 1.0f + ratio * ratio);
}

/// Density per sr, seen from the ray's origin, of a density per m^2 at the point where the unit
/// direction dir meets a surface of normal n_geom at distance t; 0 edge on.
EK_FN vf pdf_sr_from_m2(vf pdf_m2, v3 n_geom, v3 dir, vf t) {
  const vf cos_light = abs_f(dot3(n_geom, dir));
  return cos_light > 0.0f ? div_f(pdf_m2 * (t * t), cos_light) : (vf)(0.0f);
}

#endif
