// SPDX-License-Identifier: Apache-2.0
// Solids that overlap or touch, by priority [Schmidt, Budge 2002, "Simple Nested Dielectrics in Ray Traced Images"]. A path's medium
// is a list of the solids that it is in (EK_HAS_nested_media): their ranks, 1 to 255, one per byte, the highest in the top byte, 0
// where there are no more. The path is in the matter of the highest alone, so that a boundary shows where that is another on its
// other side, and is passed straight on, as if it were not there, where it is the same.
//   - What is entered twice stands in the list twice: two drops of one material that overlap are one.
//   - What is left without having been entered changes nothing: at surfaces that coincide a path may meet one of the two.
//   - What does not show ends no edge: paths count what they crossed (path_state.def), and take it off their depth.
//   - A fifth pushes out the lowest, which then is left unseen.
// Radiance over the square of the index of refraction is the same along a path, whatever the order in which boundaries are met:
// each boundary that shows takes the path from the one index to the other, and no other event changes it.
#ifndef EK_NESTED_MEDIA_H
#define EK_NESTED_MEDIA_H
#include "surface/material.h"

// Boundaries that a path passes unseen before they count as any others: far more than lie on any ray, so that every path ends.
#define EK_CROSSED_MOST 4096u

/// The rank of the medium that counts; 0 outside of all.
EK_FN vu media_top(vu media) { return media >> 24; }

/// The list with one more; rank 0 changes nothing.
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

/// The list with one less, if it is there.
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

/// The material of the medium that counts, of a list that is not empty; some material where it is.
EK_FN vu media_material(SceneData scene, vu media) {
  const vu rank = media_top(media);
  return load_word_u(MaterialExtension, scene.material_extensions, rank != 0u ? rank - 1u : (vu)(0u), medium_of_rank);
}

/// Index of refraction there; 1 outside, 0 where it stands for infinity.
EK_FN vf media_index(SceneData scene, vu media) {
  const vf ior = load_word_f(MaterialRecord, scene.materials, media_material(scene, media), ior);
  return media != 0u ? ior : (vf)(1.0f);
}

/// What radiance is outside of all solids, over what it is here.
EK_FN vf media_radiance_outside(SceneData scene, vu media) {
  const vf index = media_index(scene, media);
  return fresnel_is_mirror(index) ? (vf)(1.0f) : index * index;
}

/// Gives a solid's boundary the indices of the media that it is between; returns where it does not show.
/// media, beyond  the media on the ray's side of it and on the other;  front: its front was hit
EK_FN vi media_meet(SceneData scene, vu media, vu beyond, vi front, HitMaterial* hit) {
  const vi solid = hit->bsdf.solid;
  const vi hidden = solid & (media_top(media) == media_top(beyond));
  if (!ANY(solid)) return hidden;
  // Where it shows, the solid itself is on one side of it.
  const vu other = front ? media : beyond;
  const vf ior = media_index(scene, other), zero = (vf)(0.0f);
  const v3 f0 = dielectric_f0(hit->ior, ior, hit->specular_color, hit->bsdf.specular);
  hit->other_ior = ior;
  hit->bsdf.eta = solid ? (front ? hit->ior / ior : ior / hit->ior) : hit->bsdf.eta;
  hit->bsdf.f0_dielectric = select3(solid & (ior + hit->ior > 0.0f), f0, hit->bsdf.f0_dielectric);
  if (EK_HAS_dispersion) {
    const vf spread = material_spread(scene, media_material(scene, other));
    hit->other_spread = (solid & !hidden & (other != 0u)) ? spread : zero;
    hit->spread = hidden ? zero : hit->spread;
  }
  return hidden;
}

/// A sample that goes straight on where a boundary does not show.
EK_FN BsdfSample media_pass(vi hidden, BsdfSample s) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  s.weight = select3(hidden, V3(one, one, one), s.weight);
  s.wi = select3(hidden, V3(zero, zero, -one), s.wi);
  s.pdf = hidden ? one : s.pdf;
  s.delta = s.delta | hidden;
  return s;
}

#endif
