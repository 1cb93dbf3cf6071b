// SPDX-License-Identifier: Apache-2.0
// Opacity [glTF 2.0, section 3.9.4]: whether a ray meets a surface of alphaMode MASK or BLEND or passes it. The decision is a
// pure function of the ray's key and the triangle, so the order in which a tree is traversed does not show.
#ifndef EK_ALPHA_H
#define EK_ALPHA_H
#include "material.h"
#include "sampler.h"

/// Key of one ray's decisions. kind: 0 the path's own ray of that depth, 1 its shadow ray
EK_FN vu opacity_key(vu key, vu index, uint depth, uint kind) {
  return hash_bits(hash_bits(key ^ hash_bits(index + 0x9e3779b9u)) + (2u * depth + kind) * 0x85ebca6bu);
}

/// Whether the ray of key `key` passes `triangle` (of material record `record`) at u, v.
EK_FN vi passes(SceneData scene, Rec record, vu triangle, vf u, vf v, vu key) {
  const vf opacity = material_opacity(scene, record, hit_attributes(scene, triangle, u, v));
  return to_unit_float(hash_bits(key ^ hash_bits(triangle + 0x68bc21ebu))) >= opacity;
}

#endif
