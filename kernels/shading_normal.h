// SPDX-License-Identifier: Apache-2.0
// The normal that a surface is shaded with: interpolated, turned by a normal map, and kept where both are of use.
#ifndef EK_SHADING_NORMAL_H
#define EK_SHADING_NORMAL_H
#include "material.h"
#include "surface.h"

// Least cosine between the shading normal and the viewer, where the surface itself allows it.
#define EK_LEAST_COSINE 0x1p-7f

/// `n_shade` turned by a normal map: x along the mesh's tangent, y along its bitangent [glTF 2.0, section 3.9.3].
/// normal_texture  index, or EK_NO_TEXTURE
/// returns unit; n_shade where there is no map, no tangent, or the map says nothing or points below the surface
EK_FN v3 mapped_normal(SceneData scene, vu normal_texture, vu triangle, Coordinates at, vf u, vf v, v3 n_shade, v3 n_geom) {
  const vi has = normal_texture != EK_NO_TEXTURE;
  if (!ANY(has)) return n_shade;
  const vu texture = has ? normal_texture : (vu)(0u);
  const v4 texel = texture_sample(scene.textures, scene.texels, texture, at.uv0_u, at.uv0_v, at.uv1_u, at.uv1_v);
  const vf scale = gather_f((global const float*)scene.textures, texture * 16u + 10u);
  const v3 mapped = V3((texel.x * 2.0f - 1.0f) * scale, (texel.y * 2.0f - 1.0f) * scale, texel.z * 2.0f - 1.0f);
  const Rec r = rec16(scene.triangle_tangents, triangle);
  const v3 along = V3(interpolate(r.w0, r.w3, r.w6, u, v), interpolate(r.w1, r.w4, r.w7, u, v),
                      interpolate(r.w2, r.w5, r.w8, u, v));
  // Gram-Schmidt: interpolation takes the tangent out of the plane of the normal.
  const v3 flat = sub3(along, scale3(n_shade, dot3(along, n_shade)));
  const vf length2 = dot3(flat, flat);
  const v3 tangent = scale3(flat, (vf)(1.0f) / sqrt(length2));
  const v3 bitangent = scale3(cross3(n_shade, tangent), r.w9);
  const v3 turned = add3(add3(scale3(tangent, mapped.x), scale3(bitangent, mapped.y)), scale3(n_shade, mapped.z));
  const vf turned2 = dot3(turned, turned);
  const vi good = has & (length2 > 0x1p-20f) & (turned2 > 0x1p-20f) & (dot3(turned, n_geom) > 0.0f);
  return select3(good, scale3(turned, (vf)(1.0f) / sqrt(turned2)), n_shade);
}

/// Bends a shading normal that the viewer sees from behind just far enough towards him: silhouettes would be black.
/// Normals of surfaces that reflect (mask `glossy`) are bent until the mirror direction leaves the surface too.
/// All on the viewer's side: n_geom and n_shade in one hemisphere, wo in that of n_geom. Flat shading is never changed.
/// source  [Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", section A.3]
EK_FN v3 usable_normal(v3 n_shade, v3 n_geom, v3 wo, vi glossy) {
  const vf cos_geom = dot3(wo, n_geom);
  const vf least = min_f(cos_geom, (vf)(EK_LEAST_COSINE));
  const vf cos_shade = dot3(wo, n_shade);
  const vi behind = cos_shade < least;
  v3 n = select3(behind, normalize3(add3(n_shade, scale3(wo, least - cos_shade))), n_shade);
  const v3 mirrored = sub3(scale3(n, 2.0f * dot3(wo, n)), wo);
  const vf above = dot3(mirrored, n_geom);
  const vi sinks = glossy & (above < least);
  if (ANY(sinks)) {
    const v3 lifted = normalize3(add3(mirrored, scale3(n_geom, least - above)));
    n = select3(sinks, normalize3(add3(wo, lifted)), n);
  }
  return n;
}

/// Fades light that reaches a shading hemisphere from near the surface's own horizon, where it would end abruptly.
/// wi on the front of both normals. 1 where they are equal.
/// source  [Chiang, Li, Burley 2019, "Taming the Shadow Terminator", equation 3]
EK_FN vf terminator_factor(v3 wi, v3 n_geom, v3 n_shade) {
  const vf ratio = dot3(wi, n_geom) / (dot3(wi, n_shade) * dot3(n_geom, n_shade));
  const vf g = ratio < 1.0f ? ratio : (vf)(1.0f);
  return ((g - g * g) + 1.0f) * g;
}

#endif
