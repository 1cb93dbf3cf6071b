// SPDX-License-Identifier: Apache-2.0
// Radiance of an area light at the point that light_sample chose: its emissive texture, and its
// opacity, which a shadow ray cannot see since it ends before the light. hit_material does the same
// for rays that meet the light.
#ifndef EK_LIGHT_EMISSION_H
#define EK_LIGHT_EMISSION_H
#include "lights/light.h"
#include "surface/material.h"

// Attributes of an area light's surface at the sample's point.
// triangle  s.triangle, or any other index where the light is no surface
EK_FN HitAttributes light_attributes(SceneData scene, LightSample s, vu triangle) {
  HitAttributes at = hit_attributes(scene, triangle, s.b1, s.b2);
  if (EK_HAS_shape_light) {
    at.uv0_u = s.is_shape ? s.b1 : at.uv0_u;
    at.uv0_v = s.is_shape ? s.b2 : at.uv0_v;
    at.uv1_u = s.is_shape ? s.b1 : at.uv1_u;
    at.uv1_v = s.is_shape ? s.b2 : at.uv1_v;
  }
  return at;
}

/// The sample's radiance with texture and opacity; unchanged for lights that are no surfaces.
EK_FN v3 light_emission(SceneData scene, LightSample s) {
  if (!(EK_HAS_area & (EK_HAS_emissive_texture | EK_HAS_opacity))) return s.radiance;
  const vi is_area = !(s.is_distant | s.is_punctual);
  const vu triangle = is_area ? s.triangle : (vu)(0u);
  const MaterialRecordLanes r = load_material(scene.materials, load_word_u(Triangle, scene.triangles, triangle, material));
  const HitAttributes at = light_attributes(scene, s, triangle);
  v3 radiance = s.radiance;
  if (EK_HAS_emissive_texture) {
    const v4 c = texture_or(scene, r.emissive_texture, at, (vf)(1.0f));
    radiance = mul3(radiance, V3(c.x, c.y, c.z));
  }
  if (EK_HAS_opacity) radiance = scale3(radiance, material_opacity(scene, r, at));
  return select3(is_area, radiance, s.radiance);
}

/// Transmittance of the clearcoat of a light's surface towards a point; 1 for lights that are no
/// surfaces, and for the inside of solids, which have no coat.
/// wi  world, unit: from the point to the light
EK_FN vf light_coat(SceneData scene, LightSample s, v3 wi) {
  const vi is_area = !(s.is_distant | s.is_punctual);
  const vu triangle = is_area ? s.triangle : (vu)(0u);
  const vu material = load_word_u(Triangle, scene.triangles, triangle, material);
  const LayerDetailLanes r = load_layer_detail(scene.material_details, material);
  vf clearcoat = r.clearcoat;
  if (EK_HAS_clearcoat_texture)
    clearcoat = clearcoat * texture_or(scene, r.clearcoat_texture, light_attributes(scene, s, triangle), (vf)(1.0f)).x;
  const vf cosine = dot3(s.n, wi);
  const vi solid = (load_word_u(MaterialRecord, scene.materials, material, flags) & EK_MATERIAL_SOLID) != 0u;
  return (is_area & !(solid & (cosine > 0.0f))) ? clearcoat_passes(clearcoat, cosine) : (vf)(1.0f);
}

#endif
