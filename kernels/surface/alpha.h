// SPDX-License-Identifier: Apache-2.0
// The alpha test [glTF 2.0, section 3.9.4]: it decides whether a ray meets a surface of alphaMode
// MASK or BLEND or passes through. The decision is a pure function of the ray and the triangle, so
// it does not depend on the order in which a tree is traversed.
//
// Rays pass most surfaces within the traversal. The openings in the boundary of a solid are the
// exception, because a path that passes one is in another medium behind it: such a boundary is
// always hit, and shade_material (stages/shade/material.h) makes a null interface of an opening.
// So it is a boundary to shadow rays, as all glass is. host/pack/geometry/solid_openings.h tells
// the surfaces.
#ifndef EK_ALPHA_H
#define EK_ALPHA_H
#include "surface/material.h"
#include "lanes/sampler.h"

/// The random numbers of a ray's decisions depend on these.
typedef struct {
  vu key;    // of pixel, replicate, depth and kind of ray
  vu index;  // of the sample in its replicate
} OpacityKey;

/// Key of one ray's decisions. key, index: of its path (sampler.h); kind: 0 the path's own ray of
/// that depth, 1 its shadow ray
EK_FN OpacityKey opacity_key(vu key, vu index, uint depth, uint kind) {
  OpacityKey k = {hash_bits(key ^ ((2u * depth + kind) * 0x85ebca6bu + 0x68bc21ebu)), index};
  return k;
}

/// Random number that decides about `triangle`, uniform in [0, 1). Each triangle has a dimension of
/// its own, padded as those of sample_2d_bits are: it is independent of every other, and over the
/// samples of a pixel it is a low-discrepancy sequence.
EK_FN vf opacity_number(OpacityKey ray, vu triangle) {
  const vu seed = hash_bits(ray.key ^ hash_bits(triangle + 0x9e3779b9u));
  vu seed_a = (seed ^ 0x6a09e667u) * 0x2c1b3c6du;
  seed_a ^= seed_a >> 15;
  const vu shuffled = reverse_bits(laine_karras(reverse_bits(ray.index), seed));
  return to_unit_float(reverse_bits(laine_karras(shuffled, seed_a)));
}

/// A shape in the place of opacity_number's triangle: that depends on the shape's own number,
/// because the number of its record depends on how meshes are stored.
/// root  number of the hit along the ray, since each is decided anew
EK_FN vu shape_opacity_surface(vu shape, uint root) { return (shape | 0x80000000u) ^ (root * 0x9e3779b9u); }

/// Opacity of `triangle` where its second and third corner have weights u and v, [0, 1].
EK_FN vf opacity_at(SceneData scene, vu triangle, vf u, vf v) {
  const vu material = load_word_u(Triangle, scene.triangles, triangle, material);
  return material_opacity(scene, load_material(scene.materials, material), hit_attributes(scene, triangle, u, v));
}

/// Mask of the lanes whose ray passes through `triangle` at u, v. Lanes without a ray need no more
/// than a valid triangle.
EK_FN vi alpha_test_rejects(SceneData scene, vu triangle, vf u, vf v, OpacityKey ray) {
  const vf opacity = opacity_at(scene, triangle, u, v);
  vf number = (vf)(0.0f);  // the right decision for opacity 0 and 1
  if (ANY((opacity > 0.0f) & (opacity < 1.0f))) number = opacity_number(ray, triangle);
  return number >= opacity;
}

/// Tells triangles that rays may pass through; cheap, so to be asked first.
EK_FN int is_alpha_tested(SceneData scene, uint triangle) {
  return (scene.triangles[triangle].flags & EK_TRIANGLE_ALPHA_TESTED) != 0u;
}

#endif
