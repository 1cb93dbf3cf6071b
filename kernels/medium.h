// SPDX-License-Identifier: Apache-2.0
// The inside of solids [KHR_materials_volume]: which one a ray is in, and what it absorbs. A path remembers one medium, 1 + the
// index of its material, or 0 for none; solids that overlap are not told apart: leaving either leaves both.
#ifndef EK_MEDIUM_H
#define EK_MEDIUM_H
#include "material.h"

/// The medium of a ray that leaves a surface. front: its front side was hit; transmitted: the ray went to the other side
EK_FN vu medium_after(MaterialLanes m, vu medium, vu material, vi front, vi transmitted) {
  const vu crossed = front ? material + 1u : (vu)(0u);
  return (transmitted & m.solid) ? crossed : medium;
}

/// log2 of the transmittance of a metre, <= 0 per channel; 0 outside.
EK_FN v3 medium_absorption(SceneData scene, vu medium) {
  const vi inside = medium != 0u;
  const v3 zero = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
  if (!ANY(inside)) return zero;
  return select3(inside, material_absorption(scene, inside ? medium - 1u : (vu)(0u)), zero);
}

/// What is left of light after `distance` metres [Beer's law; KHR_materials_volume, "Attenuation"]: 1 where nothing absorbs,
/// however far, and at distance 0, however dense.
EK_FN v3 transmittance(v3 absorption, vf distance) {
  const vf far = min_f(distance, (vf)(0x1p100f));
  return V3(exp2_f(absorption.x * far), exp2_f(absorption.y * far), exp2_f(absorption.z * far));
}

#endif
