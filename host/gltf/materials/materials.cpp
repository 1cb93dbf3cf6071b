// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "gltf/light_groups.h"
#include "gltf/materials/material_extensions.h"
#include "gltf/materials/material_factors.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr const char* kPbr = "pbrMetallicRoughness";
constexpr double kMaxPriority = 1e6;

AlphaMode alpha_mode_of(const JsonView& view, Notes& notes) {
  const Json* mode = member(view.value, "alphaMode");
  if (mode == nullptr || equals(mode, "OPAQUE")) return AlphaMode::opaque;
  if (equals(mode, "MASK")) return AlphaMode::mask;
  if (equals(mode, "BLEND")) return AlphaMode::blend;
  notes.warn(fmt::format("{}: alphaMode {} is none of OPAQUE, MASK, BLEND; taken as OPAQUE", view.label(),
                         in_quotes(to_string(*mode))));
  return AlphaMode::opaque;
}

void read_priority(const JsonView& view, Material& material, Notes& notes) {
  const char* key = "mediumPriority";
  const Json* extras = member(view.value, "extras");
  if (member(extras, key) == nullptr) return;
  const double value = *as_number({.value = *extras, .kind = "extras", .parent = &view}, key);
  const double whole = std::nearbyint(std::clamp(value, -kMaxPriority, kMaxPriority));
  if (whole != value)
    notes.mended(fmt::format("{}: {} {:g} is no integer within +-{:g}; taken as {:g}", view.label(), key, value,
                             kMaxPriority, whole));
  material.medium_priority = static_cast<std::int32_t>(whole);
}

Material read_factors(const JsonView& view, Notes& notes) {
  const Factors factors(view, notes);
  Material material;
  const Json* pbr = member(view.value, kPbr);
  material.base_color = factors.color(pbr, "baseColorFactor", 1.0);
  if (const Json* rgba = member(pbr, "baseColorFactor"))
    material.opacity = factors.clamped(number_at(*rgba, 3), "baseColorFactor", 0.0, 1.0);
  material.metallic = factors.unit(pbr, "metallicFactor", 1.0);
  material.roughness = factors.unit(pbr, "roughnessFactor", 1.0);
  material.emission = factors.color(&view.value, "emissiveFactor", 0.0);
  material.alpha_mode = alpha_mode_of(view, notes);
  material.alpha_cutoff = factors.not_negative(number_of(&view.value, "alphaCutoff", 0.5), "alphaCutoff");
  if (const Json* sided = member(view.value, "doubleSided")) material.double_sided = to_boolean(*sided);
  read_priority(view, material, notes);
  read_material_extensions(view, factors, material);
  return material;
}

}  // namespace

MaterialReader::MaterialReader(const Document& document, WrongParts& wrong, TextureReader& textures,
                               MeasuredReader& measured, Scene& scene, Notes& notes)
    : document_(document.json),
      wrong_(wrong),
      textures_(textures),
      measured_(measured),
      scene_(scene),
      notes_(notes),
      used_(count_of(document.json, "materials"), false) {
  scene.materials.reserve(used_.size() + 1);
  for (std::size_t i = 0; i < used_.size(); ++i) read(i);
  note_specular_glossiness();
}

// A wrong material keeps its place and its light group, so that others keep their numbers.
void MaterialReader::read(std::size_t index) {
  const JsonView view = view_of(index);
  Material& material = scene_.materials.emplace_back();
  const auto unless_wrong = [&](const auto& action) {
    try {
      action();
    } catch (const InputError& error) {
      wrong_.add(view, error.what());
    }
  };
  unless_wrong([&] { material = read_factors(view, notes_); });
  if (const Json* name = member(view.value, "name")) material.name = to_string(*name);
  unless_wrong([&] { material.light_group = light_group_of(view, scene_); });
}

void MaterialReader::note_specular_glossiness() {
  std::string first;
  std::size_t count = 0;
  for (std::size_t i = 0; i < used_.size(); ++i) {
    const JsonView view = view_of(i);
    if (extension_of(view.value, kSpecularGlossiness) != nullptr && count++ == 0) first = view.label();
  }
  if (count == 0) return;
  notes_.warn(fmt::format("{}{}: {} is archived; taken as a dielectric with its specular colour over its diffuse one",
                          first, count > 1 ? fmt::format(" and {} more", count - 1) : "", kSpecularGlossiness));
}

JsonView MaterialReader::view_of(std::size_t index) const {
  return {.value = element(items(document_, "materials"), index),
          .kind = "material",
          .index = static_cast<std::int64_t>(index)};
}

std::uint32_t MaterialReader::use(std::optional<std::size_t> index) {
  if (!index) {
    if (scene_.materials.size() == used_.size()) scene_.materials.emplace_back().name = "default";
    return static_cast<std::uint32_t>(used_.size());
  }
  if (!used_[*index]) {
    wrong_.check("material", *index);
    const JsonView view = view_of(*index);
    find_textures(view, scene_.materials[*index]);
    note_unsupported_extensions(view.value, ExtensionOwner::material, view.label(), notes_);
    measured_.complete(view, scene_.materials[*index]);
  }
  used_[*index] = true;
  return static_cast<std::uint32_t>(*index);
}

// Textures whose factor is 0 are not looked for. The order is part of the scene's hash.
// occlusionTexture is shadow baked for renderers that cannot see it; rays do, so it is left out on
// purpose and not named.
void MaterialReader::find_textures(const JsonView& view, Material& material) {
  const auto part = [&](const char* name, const Json* json, const char* key, bool srgb) {
    return json == nullptr ? std::nullopt : textures_.find({.value = *json, .kind = name, .parent = &view}, key, srgb);
  };
  const bool is_glossy = extension_of(view.value, kSpecularGlossiness) != nullptr;  // it replaces both of these
  const Json* const pbr = is_glossy ? nullptr : member(view.value, kPbr);
  const bool lit = !material.unlit;
  material.base_color_texture = part(kPbr, pbr, "baseColorTexture", true);
  if (lit && (material.metallic > 0 || material.roughness > 0))
    material.metallic_roughness_texture = part(kPbr, pbr, "metallicRoughnessTexture", false);
  if (material.emission != glm::vec3(0.0F)) material.emissive_texture = textures_.find(view, "emissiveTexture", true);
  const char *transmission = "KHR_materials_transmission", *specular = "KHR_materials_specular";
  if (material.transmission > 0)
    material.transmission_texture =
        part(transmission, extension_of(view.value, transmission), "transmissionTexture", false);
  const bool may_be_dielectric = material.metallic < 1 || material.metallic_roughness_texture;
  if (lit && material.specular > 0 && may_be_dielectric) {
    const Json* const extension = is_glossy ? nullptr : extension_of(view.value, specular);
    material.specular_texture = part(specular, extension, "specularTexture", false);
    if (material.specular_color != glm::vec3(0.0F))
      material.specular_color_texture = part(specular, extension, "specularColorTexture", true);
  }
  if (const Json* normal = member(view.value, "normalTexture")) {
    material.normal_scale = normal_scale_of(view, *normal, "normalTexture");
    if (lit && material.normal_scale != 0) material.normal_texture = textures_.find(view, "normalTexture", false);
  }
  find_extension_textures(view, textures_, material);
}

}  // namespace eikon
