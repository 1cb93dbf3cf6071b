// SPDX-License-Identifier: Apache-2.0
// The material of a hit: the record's factors times its textures at the hit and the mesh's vertex
// colour [glTF 2.0, section 3.9].
#ifndef EK_MATERIAL_H
#define EK_MATERIAL_H
#include "surface/attributes.h"
#include "bsdf/bsdf.h"
#include "surface/texture.h"

/// The value of a texture; `otherwise` in each channel of materials that have none.
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

/// The probability that a ray meets the surface at this point rather than passing, [0, 1]; 0 or 1
/// for alphaMode MASK.
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

/// The parameters of the BSDF, and what else shading needs of a material.
typedef struct {
  MaterialLanes bsdf;
  v3 emission;      // radiance, W / (sr m^2)
  vi double_sided;  // emits on both sides
  vi unlit;
  vu normal_texture;
  vu clearcoat_normal_texture;
  vf ior;           // index of refraction of G
  vf spread;        // that of R is so much less, and of B more; 0 where a solid does not disperse
  vf other_ior, other_spread;  // the same of the medium on the other side
  v3 specular_color;
  vu medium_rank;   // nested_media.h
  vf anisotropy_x, anisotropy_y;  // direction of anisotropy along tangent and bitangent, unit
} HitMaterial;

/// Adds KHR_materials_anisotropy; surfaces without a tangent have none.
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
  const vf inverse = div_f(1.0f, sqrt_f(usable ? length2 : one));
  hit->anisotropy_x = (r.anisotropy_cos * x - r.anisotropy_sin * y) * inverse;
  hit->anisotropy_y = (r.anisotropy_sin * x + r.anisotropy_cos * y) * inverse;
  strength = usable ? strength : (vf)(0.0f);
  const vf alpha = hit->bsdf.ggx_alpha;
  hit->bsdf.ggx_alpha_x = alpha + (1.0f - alpha) * (strength * strength);
}

/// The solid's index of refraction is larger by this for blue, and smaller for red (`spread` of
/// its detail).
EK_FN vf material_spread(SceneData scene, vu material) {
  return load_word_f(MaterialDetail, scene.material_details, material, spread);
}

/// Adds KHR_materials_clearcoat and _sheen.
/// bare  mask: nothing lies on it (the inside of a solid)
EK_FN void add_layers(SceneData scene, LayerDetailLanes e, HitAttributes at, vi bare, HitMaterial* hit) {
  const vf one = (vf)(1.0f);
  vf clearcoat = bare ? (vf)(0.0f) : e.clearcoat, clearcoat_roughness = e.clearcoat_roughness;
  vf sheen_roughness = e.sheen_roughness;
  v3 sheen = V3(bare ? (vf)(0.0f) : e.sheen_color.x, bare ? (vf)(0.0f) : e.sheen_color.y, bare ? (vf)(0.0f) : e.sheen_color.z);
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

/// The share of emitted light that a coat lets through [KHR_materials_clearcoat,
/// "Emission"].
/// cosine  of the direction with the surface itself, without its shading normals: light sampling
///         does not know those
EK_FN vf clearcoat_passes(vf clearcoat, vf cosine) {
  return 1.0f - clearcoat * coat_reflectance(abs_f(cosine));
}

/// Adds KHR_materials_iridescence.
EK_FN void add_iridescence(SceneData scene, BaseDetailLanes r, HitAttributes at, MaterialLanes* m) {
  vf share = r.iridescence, place = (vf)(1.0f);
  if (EK_HAS_iridescence_texture) {
    share = share * texture_or(scene, r.iridescence_texture, at, (vf)(1.0f)).x;
    place = texture_or(scene, r.thin_film_thickness_texture, at, (vf)(1.0f)).y;
  }
  m->iridescence = share;
  m->thin_film_index = r.thin_film_index;
  m->thin_film_thickness = (r.thin_film_least_nm + (r.thin_film_most_nm - r.thin_film_least_nm) * place) * 1e-9f;
}

/// Adds KHR_materials_diffuse_transmission.
EK_FN void add_diffuse_transmission(SceneData scene, BaseDetailLanes r, HitAttributes at, MaterialLanes* m) {
  m->diffuse_transmission = r.diffuse_transmission;
  m->diffuse_transmission_color = r.diffuse_transmission_color;
  if (EK_HAS_diffuse_transmission_texture) {
    const v4 c = texture_or(scene, r.diffuse_transmission_color_texture, at, (vf)(1.0f));
    m->diffuse_transmission =
        r.diffuse_transmission * texture_or(scene, r.diffuse_transmission_texture, at, (vf)(1.0f)).w;
    m->diffuse_transmission_color = mul3(m->diffuse_transmission_color, V3(c.x, c.y, c.z));
  }
}

/// Reflectance at normal incidence of the dielectric part [KHR_materials_ior,
/// KHR_materials_specular]: an index of 0 stands for infinity.
EK_FN v3 dielectric_f0(vf ior, vf other_ior, v3 specular_color, vf specular) {
  const vf one = (vf)(1.0f), ratio = div_f(ior - other_ior, ior + other_ior);
  return scale3(V3(min_f(ratio * ratio * specular_color.x, one), min_f(ratio * ratio * specular_color.y, one),
                   min_f(ratio * ratio * specular_color.z, one)),
                specular);
}

/// The values of a material's record, its textures and the vertex colour; all others are 0.
EK_FN HitMaterial base_material(SceneData scene, MaterialRecordLanes r, HitAttributes at) {
  const vf one = (vf)(1.0f);
  const v3 white = V3(one, one, one);
  HitMaterial hit = {.bsdf = {.lobes = r.flags & 0xffu,
                              .base_color = r.base_color,
                              .metallic = r.metallic,
                              .specular = one,
                              .solid = (r.flags & EK_MATERIAL_SOLID) != 0u,
                              .clearcoat_normal = V3((vf)(0.0f), (vf)(0.0f), one),
                              .thin_film_index = one,
                              .measured = (global const float*)scene.texels},
                     .emission = r.emission,
                     .double_sided = (r.flags & EK_MATERIAL_DOUBLE_SIDED) != 0u,
                     .unlit = (r.flags & EK_MATERIAL_UNLIT) != 0u,
                     .normal_texture = r.normal_texture,
                     .clearcoat_normal_texture = (vu)(EK_NO_TEXTURE),
                     .ior = r.ior,
                     .other_ior = one,
                     .specular_color = white,
                     .anisotropy_x = one};
  vf roughness = r.roughness;
  if (EK_HAS_base_color_texture) {
    const v4 c = texture_or(scene, r.base_color_texture, at, one);
    hit.bsdf.base_color = mul3(hit.bsdf.base_color, V3(c.x, c.y, c.z));
  }
  if (EK_HAS_vertex_color)
    hit.bsdf.base_color = mul3(hit.bsdf.base_color, V3(at.color_r, at.color_g, at.color_b));
  if (EK_HAS_emissive_texture) {
    const v4 c = texture_or(scene, r.emissive_texture, at, one);
    hit.emission = mul3(hit.emission, V3(c.x, c.y, c.z));
  }
  if (EK_HAS_metallic_roughness_texture) {
    const v4 c = texture_or(scene, r.metallic_roughness_texture, at, one);
    roughness = roughness * c.y;
    hit.bsdf.metallic = hit.bsdf.metallic * c.z;
  }
  hit.bsdf.ggx_alpha = hit.bsdf.ggx_alpha_x = roughness * roughness;
  return hit;
}

/// Adds KHR_materials_specular, _transmission, _volume and EIKON_materials_measured.
EK_FN void add_extension(SceneData scene, MaterialExtensionLanes e, HitAttributes at, HitMaterial* hit) {
  const vf one = (vf)(1.0f);
  hit->medium_rank = e.medium_rank;
  hit->bsdf.specular = e.specular;
  hit->specular_color = e.specular_color;
  hit->bsdf.transmission = e.transmission;
  hit->bsdf.measured_table = e.measured_table;
  if (EK_HAS_transmission_texture)
    hit->bsdf.transmission = hit->bsdf.transmission * texture_or(scene, e.transmission_texture, at, one).x;
  if (EK_HAS_specular_texture) {
    hit->bsdf.specular = hit->bsdf.specular * texture_or(scene, e.specular_texture, at, one).w;
    const v4 c = texture_or(scene, e.specular_color_texture, at, one);
    hit->specular_color = mul3(hit->specular_color, V3(c.x, c.y, c.z));
  }
}

/// Adds what the details of material `index` say. front  mask: the front side was hit
EK_FN void add_details(SceneData scene, vu index, HitAttributes at, vi front, HitMaterial* hit) {
  hit->bsdf.own = load_lobe_detail(scene.material_details, index);
  if (EK_HAS_clearcoat | EK_HAS_sheen | EK_HAS_anisotropy) {
    const LayerDetailLanes e = load_layer_detail(scene.material_details, index);
    if (EK_HAS_clearcoat | EK_HAS_sheen) add_layers(scene, e, at, hit->bsdf.solid & !front, hit);
    if (EK_HAS_anisotropy) add_anisotropy(scene, e, at, hit);
  }
  if (EK_HAS_dispersion | EK_HAS_diffuse_transmission | EK_HAS_iridescence) {
    const BaseDetailLanes e = load_base_detail(scene.material_details, index);
    if (EK_HAS_diffuse_transmission) add_diffuse_transmission(scene, e, at, &hit->bsdf);
    if (EK_HAS_dispersion) hit->spread = hit->bsdf.solid ? e.spread : (vf)(0.0f);
    if (EK_HAS_iridescence) add_iridescence(scene, e, at, &hit->bsdf);
  }
}

#if !EK_CHUNKED
/// The record with what a kernel for hits of one class knows of it beforehand, so that code for all
/// else vanishes.
EK_FN MaterialRecordLanes record_of_class(SceneData scene, MaterialRecordLanes r) {
  const uint lobe_bits = 0xffu, transmits = 1u << LOBE_transmission;
  if (shades_only(scene, SHADING_TRANSMISSIVE)) r.flags = (r.flags & ~lobe_bits) | transmits;
  if (shades_only(scene, SHADING_OPAQUE)) r.flags = r.flags & ~(transmits | EK_MATERIAL_SOLID);
  if (shades_only(scene, SHADING_FLAT_LAMBERT)) {
    r.flags = (r.flags & ~(lobe_bits | EK_MATERIAL_SOLID)) | 1u << LOBE_diffuse;
    r.base_color_texture = r.emissive_texture = r.metallic_roughness_texture = r.normal_texture = EK_NO_TEXTURE;
  }
  return r;
}
#endif

/// Parameters of material `index` where a ray met a triangle with the attributes `at`.
/// front  mask: the front side was hit
EK_FN HitMaterial hit_material(SceneData scene, vu index, HitAttributes at, vi front) {
#if EK_CHUNKED
  HitMaterial hit = base_material(scene, load_material(scene.materials, index), at);
#else
  HitMaterial hit = base_material(scene, record_of_class(scene, load_material(scene.materials, index)), at);
  if (shades_only(scene, SHADING_FLAT_LAMBERT)) return hit;
#endif
  if (EK_HAS_material_extension)
    add_extension(scene, load_material_extension(scene.material_extensions, index), at, &hit);
  MaterialLanes* m = &hit.bsdf;
  const vf one = (vf)(1.0f);
  m->f0_dielectric = dielectric_f0(hit.ior, one, hit.specular_color, m->specular);
  m->f0 = add3(scale3(m->f0_dielectric, one - m->metallic), scale3(m->base_color, m->metallic));
  m->f90 = m->specular * (one - m->metallic) + m->metallic;
  m->eta = front ? hit.ior : div_f(one, hit.ior);
  add_details(scene, index, at, front, &hit);
  return hit;
}

/// log2 of the transmittance of a metre of material `index`, <= 0 per channel.
EK_FN v3 material_absorption(SceneData scene, vu index) {
  return load_material_extension(scene.material_extensions, index).absorption;
}

#endif
