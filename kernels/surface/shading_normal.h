// SPDX-License-Identifier: Apache-2.0
// The normal that a surface is shaded with: interpolated, turned by a normal map, and bent where
// the viewer would see its back.
#ifndef EK_SHADING_NORMAL_H
#define EK_SHADING_NORMAL_H
#include "surface/material.h"
#include "surface/surface.h"

// The least cosine between the shading normal and the viewer, where the surface itself allows it.
#define EK_LEAST_COSINE 0x1p-7f

/// The vector a if it is on n_geom's side, or else its mirror image in the surface; this is
/// continuous where a crosses the surface.
EK_FN v3 to_front(v3 a, v3 n_geom) {
  const vf depth = dot3(a, n_geom);
  return select3(depth < 0.0f, sub3(a, scale3(n_geom, 2.0f * depth)), a);
}

/// The interpolated vertex normal, unit and in the hemisphere of n_geom. Normals that dip below the
/// triangle, as on coarse silhouettes, are mirrored in it, which leaves no edge. Where vertex
/// normals are missing or cancel, it is n_geom itself.
EK_FN v3 shading_normal(HitAttributes at, v3 n_geom) {
  if (!EK_HAS_vertex_normal) return n_geom;
  const vf length2 = dot3(at.normal, at.normal);
  // Opposite unit normals cancel to rounding errors, whose direction means nothing; NaN fails the
  // comparison.
  const v3 unit = scale3(at.normal, div_f((vf)(1.0f), sqrt_f(length2)));
  return select3(length2 > 0x1p-20f, to_front(unit, n_geom), n_geom);
}

/// `n_shade` turned by a normal map: x along the mesh's tangent, y along its bitangent [glTF 2.0,
/// section 3.9.3].
/// normal_texture  index, or EK_NO_TEXTURE
/// returns unit, in the hemisphere of n_geom; n_shade where there is no map, no tangent, or the map
///         points inwards, which glTF does not allow
EK_FN v3 mapped_normal(SceneData scene, vu normal_texture, HitAttributes at, v3 n_shade, v3 n_geom) {
  const vi has = normal_texture != EK_NO_TEXTURE;
  if (!ANY(has)) return n_shade;
  const TextureLanes texture = load_texture(scene.textures, has ? normal_texture : (vu)(0u));
  const v4 texel = texture_sample(scene.texels, texture, at);
  const v3 mapped =
      V3((texel.x * 2.0f - 1.0f) * texture.scale, (texel.y * 2.0f - 1.0f) * texture.scale, texel.z * 2.0f - 1.0f);
  // Gram-Schmidt, because interpolation moves the tangent out of the plane of the normal.
  const v3 flat = sub3(at.tangent, scale3(n_shade, dot3(at.tangent, n_shade)));
  const vf length2 = dot3(flat, flat);
  const v3 tangent = scale3(flat, div_f((vf)(1.0f), sqrt_f(length2)));
  const v3 bitangent = scale3(cross3(n_shade, tangent), at.bitangent_sign);
  const v3 turned = add3(add3(scale3(tangent, mapped.x), scale3(bitangent, mapped.y)), scale3(n_shade, mapped.z));
  const vf turned2 = dot3(turned, turned);
  const vi good = has & (length2 > 0x1p-20f) & (mapped.z > 0.0f) & (turned2 > 0x1p-20f);
  return select3(good, to_front(scale3(turned, div_f((vf)(1.0f), sqrt_f(turned2))), n_geom), n_shade);
}

/// Bends a shading normal that the viewer sees from behind just far enough towards the viewer;
/// silhouettes would be black otherwise. Normals of surfaces that reflect (mask `glossy`) are bent
/// until the mirror direction leaves the surface, too. All vectors are on the viewer's side:
/// n_shade and wo are in the hemisphere of n_geom. Flat shading is never changed.
/// source  [Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", section
///         A.3]
EK_FN v3 usable_normal(v3 n_shade, v3 n_geom, v3 wo, vi glossy) {
  const vf cos_geom = dot3(wo, n_geom);
  const vf least = min_f(cos_geom, (vf)(EK_LEAST_COSINE));
  const vf cos_shade = dot3(wo, n_shade);
  const vi behind = cos_shade < least;
  v3 n = select3(behind, normalize3(add3(n_shade, scale3(wo, least - cos_shade))), n_shade);
  // Where n_shade is n_geom, only rounding tells `above` from cos_geom.
  const vi differs = (n_shade.x != n_geom.x) | (n_shade.y != n_geom.y) | (n_shade.z != n_geom.z);
  const vf twice = 2.0f * dot3(wo, n);
  const v3 mirrored = sub3(scale3(n, twice), wo);
  const vf above = dot3(mirrored, n_geom);
  const vi sinks = glossy & differs & (above < least);
  if (ANY(sinks)) {
    // This is the half vector of wo and the unit vector along `lifted`. wo + mirrored is written as
    // 2 (wo . n) n, which does not cancel at grazing views.
    const v3 lifted = add3(mirrored, scale3(n_geom, least - above));
    const vf shorter = above * above - least * least;  // 1 - |lifted|^2
    const vf norm = sqrt_f(max_f(1.0f - shorter, (vf)(0x1p-40f)));
    const vf stretch = div_f(shorter, norm * (1.0f + norm));  // 1 / |lifted| - 1
    const v3 half_vector = add3(add3(scale3(n, twice), scale3(n_geom, least - above)), scale3(lifted, stretch));
    n = select3(sinks, normalize3(half_vector), n);
  }
  // For directions along the surface itself the vectors above consist of rounding errors.
  return select3(cos_geom > 0x1p-20f, n, n_geom);
}

/// World direction of a material's anisotropy at a hit, not unit; zero where the mesh has no
/// tangent.
/// n_geom  to the front
EK_FN v3 anisotropy_direction(HitMaterial hit, HitAttributes at, v3 n_geom) {
  const v3 n = shading_normal(at, n_geom);
  const v3 flat = sub3(at.tangent, scale3(n, dot3(at.tangent, n)));
  const v3 across = scale3(cross3(n, flat), at.bitangent_sign);
  return add3(scale3(flat, hit.anisotropy_x), scale3(across, hit.anisotropy_y));
}

#endif
