// SPDX-License-Identifier: Apache-2.0
// The inside of solids [KHR_materials_volume]: which medium a ray is in, and what that absorbs. A
// path remembers one medium as 1 + the index of its material, or 0 for none, and leaving any solid
// leaves it. With EK_HAS_nested_media it remembers a list of media instead (nested_media.h).
#ifndef EK_MEDIUM_H
#define EK_MEDIUM_H
#include "surface/nested_media.h"

// True if paths know the medium that they are in (PathState.medium).
#define EK_USES_MEDIUM (EK_HAS_absorption | EK_HAS_nested_media)

/// The medium on the other side of a surface; the ray's own medium if the surface is not that of a
/// solid.
/// material  index of the surface's material
/// front     mask: its front side was hit
EK_FN vu transmitted_medium(HitMaterial hit, vu medium, vu material, vi front) {
  if (EK_HAS_nested_media) return front ? media_with(medium, hit.medium_rank) : media_without(medium, hit.medium_rank);
  const vu crossed = front ? material + 1u : (vu)(0u);
  return hit.bsdf.solid ? crossed : medium;
}

/// log2 of the transmittance of a metre of the medium, <= 0 per channel; 0 outside of all.
EK_FN v3 medium_absorption(SceneData scene, vu medium) {
  const vi inside = medium != 0u;
  const v3 zero = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
  if (!ANY(inside)) return zero;
  const vu material = EK_HAS_nested_media ? media_material(scene, medium) : inside ? medium - 1u : (vu)(0u);
  return select3(inside, material_absorption(scene, material), zero);
}

/// Share of light that is left after `distance` metres [Beer's law; KHR_materials_volume,
/// "Attenuation"]. It is 1 where nothing absorbs, however far, and at distance 0, however dense the
/// medium.
EK_FN v3 transmittance(v3 absorption, vf distance) {
  const vf far = min_f(distance, (vf)(0x1p100f));
  return V3(exp2_f(absorption.x * far), exp2_f(absorption.y * far), exp2_f(absorption.z * far));
}

#endif
