// SPDX-License-Identifier: Apache-2.0
// Solids that overlap or touch, by priority [Schmidt, Budge 2002, "Simple Nested Dielectrics in Ray
// Traced Images"].
//
// With EK_HAS_nested_media a path's medium is a list of the solids that it is in: their ranks, 1 to
// 255, one per byte, the highest rank in the top byte, 0 where there are no more. The path is in
// the matter of the highest rank alone. A boundary is a null interface where that rank is the same
// on both sides of it: the path then goes straight on, as if the boundary were not there.
// - A solid that is entered twice stands in the list twice, so two overlapping drops of one
//   material are one.
// - Leaving a solid that was never entered changes nothing, because a path may meet only one of two
//   surfaces that coincide.
// - Null interfaces do not count towards max_depth: paths count them (path_state.def) and take the
//   count off their depth.
// - A fifth solid pushes out the one of the lowest rank, whose boundary is then a null interface
//   when it is left.
//
// Radiance over the square of the index of refraction is constant along a path, in whatever order
// boundaries are met: each boundary that is no null interface takes the path from the one index to
// the other, and no other event changes the index.
#ifndef EK_NESTED_MEDIA_H
#define EK_NESTED_MEDIA_H
#include "surface/material.h"

// Null interfaces beyond this number count towards max_depth, so every path ends. No ray meets so
// many.
#define EK_NULL_INTERFACES_MOST 4096u

/// The rank of the medium whose matter the path is in; 0 outside of all.
EK_FN vu media_top(vu media) { return media >> 24; }

/// The list with one more solid; rank 0 changes nothing.
EK_FN vu media_with(vu media, vu rank) {
  vu list = (vu)(0u);
  for (uint i = 0; i < EK_MEDIA_MOST; ++i) {
    const uint shift = 24u - 8u * i;
    const vu at = (media >> shift) & 0xffu;
    const vi before = at < rank;
    list = list | ((before ? rank : at) << shift);
    rank = before ? at : rank;
  }
  return list;
}

/// The list without one solid of that rank, if there is one.
EK_FN vu media_without(vu media, vu rank) {
  vu list = (vu)(0u);
  vi found = (vi)(0);
  for (uint i = 0; i < EK_MEDIA_MOST; ++i) {
    const uint shift = 24u - 8u * i;
    const vu at = (media >> shift) & 0xffu, next = ((media << 8) >> shift) & 0xffu;
    found = found | (at == rank);
    list = list | ((found ? next : at) << shift);
  }
  return list;
}

/// The material whose matter the path is in; an arbitrary one if the list is empty.
EK_FN vu media_material(SceneData scene, vu media) {
  const vu rank = media_top(media);
  return load_word_u(MaterialExtension, scene.material_extensions, rank != 0u ? rank - 1u : (vu)(0u), medium_of_rank);
}

/// Index of refraction of that material; 1 outside of all, 0 stands for infinity.
EK_FN vf media_index(SceneData scene, vu media) {
  const vf ior = load_word_f(MaterialRecord, scene.materials, media_material(scene, media), ior);
  return media != 0u ? ior : (vf)(1.0f);
}

/// Radiance outside of all solids, over the same radiance in these media.
EK_FN vf media_radiance_outside(SceneData scene, vu media) {
  const vf index = media_index(scene, media);
  return fresnel_is_mirror(index) ? (vf)(1.0f) : index * index;
}

/// Gives a solid's boundary the indices of refraction of the media on its two sides.
/// media        on the ray's side of the boundary
/// transmitted  on the other side
/// front        mask: its front was hit
/// returns mask: the boundary is a null interface
EK_FN vi resolve_interface(SceneData scene, vu media, vu transmitted, vi front, HitMaterial* hit) {
  const vi solid = hit->bsdf.solid;
  const vi is_null = solid & (media_top(media) == media_top(transmitted));
  if (!ANY(solid)) return is_null;
  // At any other boundary the solid itself is on one side.
  const vu other = front ? media : transmitted;
  const vf ior = media_index(scene, other), zero = (vf)(0.0f);
  const v3 f0 = dielectric_f0(hit->ior, ior, hit->specular_color, hit->bsdf.specular);
  hit->other_ior = ior;
  hit->bsdf.eta = solid ? (front ? div_f(hit->ior, ior) : div_f(ior, hit->ior)) : hit->bsdf.eta;
  hit->bsdf.f0_dielectric = select3(solid & (ior + hit->ior > 0.0f), f0, hit->bsdf.f0_dielectric);
  if (EK_HAS_dispersion) {
    const vf spread = material_spread(scene, media_material(scene, other));
    hit->other_spread = (solid & !is_null & (other != 0u)) ? spread : zero;
    hit->spread = is_null ? zero : hit->spread;
  }
  return is_null;
}

/// The sample, replaced at null interfaces by one that goes straight on.
/// radiance  on the ray's side over that on the other side
EK_FN BsdfSample pass_null_interface(vi is_null, vf radiance, BsdfSample s) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  s.weight = select3(is_null, V3(radiance, radiance, radiance), s.weight);
  s.wi = select3(is_null, V3(zero, zero, -one), s.wi);
  s.pdf = is_null ? one : s.pdf;
  s.delta = s.delta | is_null;
  return s;
}

#endif
