// SPDX-License-Identifier: Apache-2.0
// The word PathState.light_ratio, by which camera paths and light paths share light. It is a float
// whose lowest bits hold a mark; the number itself is not exact to them. All that takes these bits
// apart is here.
//
// Of a camera path, set by stage shade (shade/light_ratio.h, which says what R is):
//   value              meaning                                               read by
//   0                  light paths bring none of the light behind            camera_share
//   > 0                the factors of R that are known so far: all but the   camera_share
//                      density of a light path's start
//   EK_SEEN_BY_DELTA   with photons: it had delta scattering alone so far,   shade/merge.h
//                      so it gathers photons at the first other surface
//   EK_MERGED          with photons: it has gathered some; what it finds     camera_share
//                      behind comes by photons, if light paths bring it
//   mark
//   lobe_mark          it leaves a glossy target: solid angle of the lobe    marked_lobe_sr
//   EK_NO_TARGET_MARK  after delta scattering: the surface is no target      is_shared_scattering
//   0                  neither
//
// Of a light path, set by stage light_generate and read by stage light_shade:
//   value              meaning
//   >= 0               density of its start, in the mean (EmittedPath)
//   < 0                minus a density, of a light without extent
//   mark, at the first surface
//   EK_PARALLEL_MARK   it starts as parallel light
//   aim_mark           else emission_aim of its light
// If the first surface is a glossy target, stage light_shade puts density_beside_sampling in the
// place of the density there.
#ifndef EK_LIGHT_RATIO_WORD_H
#define EK_LIGHT_RATIO_WORD_H
#include "bsdf/microfacet.h"
#include "lights/density.h"
#include "shared/light_target.h"

#define EK_SEEN_BY_DELTA (-1.0f)
#define EK_MERGED (-2.0f)

#define EK_RATIO_MARK 31u
#define EK_NO_TARGET_MARK EK_RATIO_MARK
#define EK_PARALLEL_MARK EK_RATIO_MARK
#define EK_LEAST_LOBE_EXPONENT (127u - 25u)  // of 2^-25 sr; smaller ones are as good as none

EK_FN vu mark_of(vf word) { return AS_U(word) & EK_RATIO_MARK; }
EK_FN vf marked(vf word, vu mark) { return AS_F((AS_U(word) & ~EK_RATIO_MARK) | mark); }
EK_FN vf unmarked(vf word) { return marked(word, (vu)(0u)); }

/// The solid angle, sr, that stands for a lobe of GGX where camera paths and light paths share
/// light: 4 pi alpha^2 over the cosine of the light with the surface. At normal incidence this is
/// the inverse of the largest density of reflected directions [Walter et al. 2007, eq. 14 and 33];
/// that it grows towards grazing incidence is a choice. All ways to find a light take the same
/// value, so it changes the variance and not the mean.
EK_FN vf lobe_sr(vf ggx_alpha, vf cosine) {
  const vf alpha = max_f(ggx_alpha, (vf)(EK_SMOOTH_ALPHA));
  return div_f((4.0f * EK_PI) * (alpha * alpha), max_f(cosine, (vf)(0x1p-10f)));
}
EK_FN vu lobe_mark(vf sr) {
  const vu exponent = AS_U(sr) >> 23;
  const vu mark = exponent > EK_LEAST_LOBE_EXPONENT ? exponent - EK_LEAST_LOBE_EXPONENT : (vu)(1u);
  return mark < EK_RATIO_MARK ? mark : (vu)(EK_RATIO_MARK);
}
/// The solid angle that stands in a mark, to a power of two; 0 if there is no mark.
EK_FN vf marked_lobe_sr(vf word) {
  if (!EK_GLOSSY_TARGETS) return (vf)(0.0f);
  const vu mark = mark_of(word);
  return mark != 0u ? AS_F((mark + EK_LEAST_LOBE_EXPONENT) << 23) : (vf)(0.0f);
}
/// The same of a glossy target's point. All ways to find a light there take this.
EK_FN vf shared_lobe_sr(vf ggx_alpha, vf cosine) { return marked_lobe_sr(AS_F(lobe_mark(lobe_sr(ggx_alpha, cosine)))); }

/// The mark of emission_aim, which is a power of two between 2^-10 and 2^19, and the reverse.
EK_FN vu aim_mark(vf aim) { return ((AS_U(aim) >> 23) - 116u) & EK_RATIO_MARK; }
EK_FN vf marked_aim(vf word) { return AS_F((mark_of(word) + 116u) << 23); }

/// Mask of the light paths that start as parallel light. word: of one that has just started
EK_FN vi starts_parallel(vf word) { return mark_of(word) == EK_PARALLEL_MARK; }
/// Mask of the light paths that start from a light without extent, which no camera path meets.
EK_FN vi starts_from_delta_light(vf word) { return word < 0.0f; }

/// Mask of the camera paths that share light with light paths.
EK_FN vi is_shared_ratio(vf word) {
  return EK_HAS_merging ? (word > 0.0f) | (unmarked(word) == EK_MERGED) : word > 0.0f;
}

/// Mask of the camera paths that share the light of a lamp, or of an environment, that they meet:
/// those that come from a target. After delta scattering targets leave no mark, and after glossy
/// scattering they leave one. pdf, word: as PathState's
EK_FN vi is_shared_scattering(vf pdf, vf word) {
  const vi is_delta = has_no_density(pdf), has_mark = mark_of(word) != 0u;
  return (EK_GLOSSY_TARGETS ? is_delta ^ has_mark : is_delta & !has_mark) & is_shared_ratio(word);
}

/// Weight of light that a camera path finds, by the balance heuristic: 1 / (1 + ratio * density).
/// After a merge it is 0 for light that light paths bring, else 1.
/// word  PathState.light_ratio; density: of a light path's start there
EK_FN vf camera_share(vf word, vf density) {
  const vf ratio = unmarked(word), share = div_f(1.0f, 1.0f + ratio * density);
  if (!EK_HAS_merging) return share;
  return ratio == EK_MERGED ? (density > 0.0f ? (vf)(0.0f) : (vf)(1.0f)) : share;
}

#endif
