// SPDX-License-Identifier: Apache-2.0
// What a hit's material is: the record's factors, its textures at the hit, the mesh's vertex colour [glTF 2.0, section 3.9].
#ifndef EK_MATERIAL_H
#define EK_MATERIAL_H
#include "surface/attributes.h"
#include "bsdf/bsdf.h"
#include "surface/texture.h"

/// The value of a texture that a material may not have: `otherwise` in each channel where it has none.
EK_FN v4 texture_or(SceneData scene, vu texture, HitAttributes at, vf otherwise) {
  const vi has = texture != EK_NO_TEXTURE;
  v4 c = {otherwise, otherwise, otherwise, otherwise};
  if (ANY(has)) {
    const v4 s = texture_sample(scene.texels, load_texture(scene.textures, has ? texture : (vu)(0u)), at);
    c.x = has ? s.x : otherwise;
    c.y = has ? s.y : otherwise;
    c.z = has ? s.z : otherwise;
    c.w = has ? s.w : otherwise;
  }
  return c;
}

/// The probability that a ray meets the surface at this point rather than passing, [0, 1]; 0 or 1 for alphaMode MASK.
/// record  of the material
EK_FN vf material_opacity(SceneData scene, MaterialRecordLanes record, HitAttributes at) {
  const vu flags = record.flags;
  vf opacity = record.opacity;
  if (EK_HAS_base_color_texture) opacity = opacity * texture_or(scene, record.base_color_texture, at, (vf)(1.0f)).w;
  if (EK_HAS_vertex_color) opacity = opacity * at.color_a;
  const vf masked = opacity >= record.alpha_cutoff ? (vf)(1.0f) : (vf)(0.0f);
  const vf chosen = (flags & EK_MATERIAL_MASK) != 0u ? masked : opacity;
  return (flags & (EK_MATERIAL_MASK | EK_MATERIAL_BLEND)) != 0u ? chosen : (vf)(1.0f);
}

// What shading needs besides the BSDF's parameters.
typedef struct {
  MaterialLanes bsdf;
  v3 emission;      // radiance, W / (sr m^2)
  vi double_sided;  // emits on both sides
  vi unlit;
  vu normal_texture;
  vu clearcoat_normal_texture;
  vf ior, spread;   // index of refraction: of G, and what R has less and B more; spread 0 where a solid does not disperse
  vf other_ior, other_spread;  // of the medium that it is met in, or left for
  v3 specular_color;
  vu medium_rank;   // nested_media.h
  vf anisotropy_x, anisotropy_y;  // its direction, unit, in terms of tangent and bitangent
} HitMaterial;

/// Adds KHR_materials_anisotropy. Without a tangent there is no direction for it.
EK_FN void add_anisotropy(SceneData scene, LayerDetailLanes r, HitAttributes at, HitMaterial* hit) {
  const vf one = (vf)(1.0f);
  vf x = one, y = (vf)(0.0f), strength = r.anisotropy;
  if (EK_HAS_anisotropy_texture) {
    const vu texture = r.anisotropy_texture;
    const vi has = texture != EK_NO_TEXTURE;
    const v4 c = texture_or(scene, texture, at, one);
    x = has ? 2.0f * c.x - 1.0f : x;
    y = has ? 2.0f * c.y - 1.0f : y;
    strength = strength * c.z;
  }
  const vf length2 = x * x + y * y;
  const vi usable = (dot3(at.tangent, at.tangent) > 0x1p-20f) & (length2 > 0x1p-20f);
  const vf inverse = 1.0f / sqrt(usable ? length2 : one);
  hit->anisotropy_x = (r.anisotropy_cos * x - r.anisotropy_sin * y) * inverse;
  hit->anisotropy_y = (r.anisotropy_sin * x + r.anisotropy_cos * y) * inverse;
  strength = usable ? strength : (vf)(0.0f);
  const vf alpha = hit->bsdf.ggx_alpha;
  hit->bsdf.ggx_alpha_x = alpha + (1.0f - alpha) * (strength * strength);
}

/// What is added to the index of a solid for blue and taken from it for red (`spread` of its detail).
EK_FN vf material_spread(SceneData scene, vu material) {
  return load_word_f(MaterialDetail, scene.material_details, material, spread);
}

/// Adds KHR_materials_clearcoat and _sheen.
/// bare  mask: nothing lies on it (the inside of a solid)
EK_FN void add_layers(SceneData scene, LayerDetailLanes e, HitAttributes at, vi bare, HitMaterial* hit) {
  const vf one = (vf)(1.0f);
  vf clearcoat = bare ? (vf)(0.0f) : e.clearcoat, clearcoat_roughness = e.clearcoat_roughness, sheen_roughness = e.sheen_roughness;
  v3 sheen = V3(bare ? (vf)(0.0f) : e.sheen.x, bare ? (vf)(0.0f) : e.sheen.y, bare ? (vf)(0.0f) : e.sheen.z);
  if (EK_HAS_clearcoat_texture) {
    clearcoat = clearcoat * texture_or(scene, e.clearcoat_texture, at, one).x;
    clearcoat_roughness = clearcoat_roughness * texture_or(scene, e.clearcoat_roughness_texture, at, one).y;
  }
  if (EK_HAS_sheen_texture) {
    const v4 c = texture_or(scene, e.sheen_color_texture, at, one);
    sheen = mul3(sheen, V3(c.x, c.y, c.z));
    sheen_roughness = sheen_roughness * texture_or(scene, e.sheen_roughness_texture, at, one).w;
  }
  if (EK_HAS_clearcoat) {
    hit->bsdf.clearcoat = clearcoat;
    hit->bsdf.clearcoat_alpha = clearcoat_roughness * clearcoat_roughness;
    hit->clearcoat_normal_texture = e.clearcoat_normal_texture;
  }
  if (EK_HAS_sheen) {
    hit->bsdf.sheen = sheen;
    hit->bsdf.sheen_roughness = sheen_roughness;
  }
}

/// What a coat lets through of the light that its surface emits [KHR_materials_clearcoat, "Emission"].
/// cosine  of the direction with the surface itself, without its shading normals: light sampling does not know those
EK_FN vf clearcoat_passes(vf clearcoat, vf cosine) {
  return 1.0f - clearcoat * (0.04f + 0.96f * schlick_weight(abs_f(cosine)));
}

/// Adds KHR_materials_iridescence.
EK_FN void add_iridescence(SceneData scene, FilmDetailLanes r, HitAttributes at, MaterialLanes* m) {
  vf share = r.iridescence, place = (vf)(1.0f);
  if (EK_HAS_iridescence_texture) {
    share = share * texture_or(scene, r.iridescence_texture, at, (vf)(1.0f)).x;
    place = texture_or(scene, r.film_texture, at, (vf)(1.0f)).y;
  }
  m->iridescence = share;
  m->film_index = r.film_index;
  m->film_thickness = (r.film_least + (r.film_most - r.film_least) * place) * 1e-9f;
}

/// Adds KHR_materials_diffuse_transmission.
EK_FN void add_translucence(SceneData scene, BaseDetailLanes r, HitAttributes at, MaterialLanes* m) {
  m->diffuse_transmission = r.diffuse_transmission;
  m->diffuse_transmission_color = r.diffuse_transmission_color;
  if (EK_HAS_diffuse_transmission_texture) {
    const v4 c = texture_or(scene, r.diffuse_transmission_color_texture, at, (vf)(1.0f));
    m->diffuse_transmission = r.diffuse_transmission * texture_or(scene, r.diffuse_transmission_texture, at, (vf)(1.0f)).w;
    m->diffuse_transmission_color = mul3(m->diffuse_transmission_color, V3(c.x, c.y, c.z));
  }
}

/// Reflectance at normal incidence of the dielectric part [KHR_materials_ior, KHR_materials_specular]: an index of 0 stands for infinity.
EK_FN v3 dielectric_f0(vf ior, vf other_ior, v3 specular_color, vf specular) {
  const vf one = (vf)(1.0f), ratio = (ior - other_ior) / (ior + other_ior);
  return scale3(V3(min_f(ratio * ratio * specular_color.x, one), min_f(ratio * ratio * specular_color.y, one),
                   min_f(ratio * ratio * specular_color.z, one)),
                specular);
}

/// Parameters of material `index` where a ray met a triangle that says `at`.
/// front  mask: the front side was hit
EK_FN HitMaterial hit_material(SceneData scene, vu index, HitAttributes at, vi front) {
  const MaterialRecordLanes r = load_material(scene.materials, index);
  const vf one = (vf)(1.0f);
  HitMaterial hit;
  MaterialLanes m;
  m.base_color = r.base_color;
  hit.emission = r.emission;
  const vu flags = r.flags;
  m.lobes = flags & 0xffu;
  hit.double_sided = (flags & EK_MATERIAL_DOUBLE_SIDED) != 0u;
  hit.unlit = (flags & EK_MATERIAL_UNLIT) != 0u;
  hit.normal_texture = r.normal_texture;
  if (EK_HAS_base_color_texture) {
    const v4 c = texture_or(scene, r.base_color_texture, at, one);
    m.base_color = mul3(m.base_color, V3(c.x, c.y, c.z));
  }
  if (EK_HAS_vertex_color) m.base_color = mul3(m.base_color, V3(at.color_r, at.color_g, at.color_b));
  if (EK_HAS_emissive_texture) {
    const v4 c = texture_or(scene, r.emissive_texture, at, one);
    hit.emission = mul3(hit.emission, V3(c.x, c.y, c.z));
  }
  m.metallic = r.metallic;
  vf roughness = r.roughness;
  if (EK_HAS_metallic_roughness_texture) {
    const v4 c = texture_or(scene, r.metallic_roughness_texture, at, one);
    roughness = roughness * c.y;
    m.metallic = m.metallic * c.z;
  }
  m.ggx_alpha = roughness * roughness;
  const vf ior = r.ior;
  vf specular = one;
  v3 specular_color = V3(one, one, one);
  m.transmission = (vf)(0.0f);
  m.measured = (global const float*)scene.texels;
  m.measured_table = (vu)(0u);
  m.solid = (flags & EK_MATERIAL_SOLID) != 0u;
  hit.medium_rank = (vu)(0u);
  if (EK_HAS_material_extension) {
    const MaterialExtensionLanes e = load_material_extension(scene.material_extensions, index);
    hit.medium_rank = e.medium_rank;
    specular = e.specular;
    specular_color = e.specular_color;
    m.transmission = e.transmission;
    m.measured_table = e.measured_table;
    if (EK_HAS_transmission_texture) m.transmission = m.transmission * texture_or(scene, e.transmission_texture, at, one).x;
    if (EK_HAS_specular_texture) {
      specular = specular * texture_or(scene, e.specular_texture, at, one).w;
      const v4 c = texture_or(scene, e.specular_color_texture, at, one);
      specular_color = mul3(specular_color, V3(c.x, c.y, c.z));
    }
  }
  m.f0_dielectric = dielectric_f0(ior, one, specular_color, specular);
  m.specular = specular;
  m.f0 = add3(scale3(m.f0_dielectric, one - m.metallic), scale3(m.base_color, m.metallic));
  m.f90 = specular * (one - m.metallic) + m.metallic;
  m.eta = front ? ior : one / ior;
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), one), none = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
  m.clearcoat = m.clearcoat_alpha = m.sheen_roughness = (vf)(0.0f);
  m.clearcoat_normal = up;
  m.sheen = m.conductor_eta = m.conductor_k = m.phong_specular = none;
  m.phong_shininess = m.iridescence = m.film_thickness = (vf)(0.0f);
  m.film_index = one;
  m.ggx_alpha_x = m.ggx_alpha;
  m.diffuse_transmission = (vf)(0.0f);
  m.diffuse_transmission_color = none;
  hit.anisotropy_x = one;
  hit.anisotropy_y = (vf)(0.0f);
  hit.clearcoat_normal_texture = (vu)(EK_NO_TEXTURE);
  hit.bsdf = m;
  if (EK_HAS_clearcoat | EK_HAS_sheen | EK_HAS_anisotropy | EK_HAS_phong) {
    const LayerDetailLanes e = load_layer_detail(scene.material_details, index);
    if (EK_HAS_clearcoat | EK_HAS_sheen) add_layers(scene, e, at, m.solid & !front, &hit);
    if (EK_HAS_anisotropy) add_anisotropy(scene, e, at, &hit);
    if (EK_HAS_phong) hit.bsdf.phong_shininess = e.phong_shininess;
  }
  hit.ior = ior;
  hit.other_ior = one;
  hit.spread = hit.other_spread = (vf)(0.0f);
  hit.specular_color = specular_color;
  if (EK_HAS_conductor | EK_HAS_dispersion | EK_HAS_diffuse_transmission | EK_HAS_phong) {
    const BaseDetailLanes e = load_base_detail(scene.material_details, index);
    if (EK_HAS_diffuse_transmission) add_translucence(scene, e, at, &hit.bsdf);
    if (EK_HAS_phong) hit.bsdf.phong_specular = e.phong;
    if (EK_HAS_dispersion) hit.spread = m.solid ? e.spread : (vf)(0.0f);
    hit.bsdf.conductor_eta = e.eta;
    hit.bsdf.conductor_k = e.k;
  }
  if (EK_HAS_iridescence) add_iridescence(scene, load_film_detail(scene.material_details, index), at, &hit.bsdf);
  return hit;
}

/// log2 of the transmittance of a metre of material `index`, <= 0 per channel.
EK_FN v3 material_absorption(SceneData scene, vu index) {
  return load_material_extension(scene.material_extensions, index).absorption;
}

#endif
