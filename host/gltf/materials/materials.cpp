// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/materials/material_factors.h"
#include "gltf/materials/material_layers.h"
#include "gltf/materials/material_measured.h"
#include "gltf/materials/material_microfacets.h"
#include "gltf/materials/material_translucence.h"

namespace eikon {
namespace {

constexpr const char* kPbr = "pbrMetallicRoughness";
constexpr const char* kDispersionExtension = "KHR_materials_dispersion";
constexpr double kMaxDispersion = 39;  // from 40 on the index of R would be 1 or less
constexpr double kMaxIor = 1e9;        // reflects all but 4e-9; squares stay finite
constexpr double kMaxPriority = 1e6;

constexpr std::array<std::string_view, 15> kKnown{"KHR_materials_specular", "KHR_materials_emissive_strength",
                                                  "KHR_materials_ior",      "KHR_materials_transmission",
                                                  "KHR_materials_volume",   "KHR_materials_unlit",
                                                  kClearcoatExtension,      kSheenExtension,
                                                  kAnisotropyExtension,     kConductorExtension,
                                                  kDispersionExtension,     kTranslucenceExtension,
                                                  kPhongExtension,          kIridescenceExtension,
                                                  kMeasuredExtension};

Place place_of(const Json& document, std::size_t index) {
  return {.value = items(document, "materials")[index], .kind = "material", .index = static_cast<std::int64_t>(index)};
}

glm::vec3 emission_of(const Place& place, const Factors& factors) {
  const char* key = "emissiveStrength";
  const glm::vec3 factor = factors.colour(&place.value, "emissiveFactor", 0.0);
  const double strength = number_of(extension_of(place, "KHR_materials_emissive_strength"), key, 1.0);
  const double legal = strength < 0 ? static_cast<double>(factors.clamped(strength, key, 0.0, 0.0)) : strength;
  glm::vec3 emission{0.0F};
  for (int c = 0; c < 3; ++c) {
    const double radiance = static_cast<double>(factor[c]) * legal;
    if (!(radiance <= kMaxFloat))
      place.refuse(fmt::format("emissiveStrength {:g} is beyond single precision; use a smaller unit", strength));
    emission[c] = static_cast<float>(radiance);
  }
  return emission;
}

AlphaMode alpha_mode_of(const Place& place, Notes& notes) {
  const Json* mode = member(place.value, "alphaMode");
  if (mode == nullptr || *mode == "OPAQUE") return AlphaMode::opaque;
  if (*mode == "MASK") return AlphaMode::mask;
  if (*mode == "BLEND") return AlphaMode::blend;
  notes.warn(fmt::format("{}: alphaMode {} is none of OPAQUE, MASK, BLEND; taken as OPAQUE", place.label(),
                         in_quotes(mode->get_ref<const std::string&>())));
  return AlphaMode::opaque;
}

void read_volume(const Place& place, const Factors& factors, Material& material, Notes& notes) {
  const Json* volume = extension_of(place, "KHR_materials_volume");
  if (volume == nullptr) return;
  // How thick the file says that it is does not matter to rays that find the other side by themselves.
  material.solid = factors.not_negative(number_of(volume, "thicknessFactor", 0.0), "thicknessFactor") > 0;
  material.attenuation_color = factors.colour(volume, "attenuationColor", 1.0);
  const char* key = "attenuationDistance";
  if (member(*volume, key) == nullptr) return;
  const double distance = number_of(volume, key, 0.0);
  if (!(distance > 0)) {
    notes.warn(fmt::format("{}: {} {:g} is not positive; taken as infinite", place.label(), key, distance));
  } else if (distance <= kMaxFloat) {
    material.attenuation_distance = static_cast<float>(std::max(distance, kMinFloat));
  }
}

void read_priority(const Place& place, Material& material, Notes& notes) {
  const char* key = "mediumPriority";
  const Json* extras = member(place.value, "extras");
  if (extras == nullptr || !extras->is_object() || member(*extras, key) == nullptr) return;
  const double value = *as_number({.value = *extras, .kind = "extras", .parent = &place}, key);
  const double whole = std::nearbyint(std::clamp(value, -kMaxPriority, kMaxPriority));
  if (whole != value)
    notes.clamped(fmt::format("{}: {} {:g} is no integer within +-{:g}; taken as {:g}", place.label(), key, value,
                              kMaxPriority, whole));
  material.medium_priority = static_cast<std::int32_t>(whole);
}

}  // namespace

Material convert_material(const Json& document, std::size_t index, Notes& notes) {
  const Place place = place_of(document, index);
  const Factors factors(place, notes);
  Material material;
  if (const Json* name = member(place.value, "name")) material.name = name->get<std::string>();
  const Json* pbr = member(place.value, kPbr);
  material.base_color = factors.colour(pbr, "baseColorFactor", 1.0);
  if (const Json* rgba = pbr == nullptr ? nullptr : member(*pbr, "baseColorFactor"))
    material.opacity = factors.clamped((*rgba)[3].get<double>(), "baseColorFactor", 0.0, 1.0);
  material.metallic = factors.unit(pbr, "metallicFactor", 1.0);
  material.roughness = factors.unit(pbr, "roughnessFactor", 1.0);
  material.emission = emission_of(place, factors);
  material.alpha_mode = alpha_mode_of(place, notes);
  material.alpha_cutoff = factors.not_negative(number_of(&place.value, "alphaCutoff", 0.5), "alphaCutoff");
  if (const Json* sided = member(place.value, "doubleSided")) material.double_sided = sided->get<bool>();

  const double ior = number_of(extension_of(place, "KHR_materials_ior"), "ior", 1.5);
  material.ior = ior == 0 ? 0.0F : factors.clamped(ior, "ior", 1.0, kMaxIor);
  const Json* specular = extension_of(place, "KHR_materials_specular");
  material.specular = factors.unit(specular, "specularFactor", 1.0);
  material.specular_color = factors.colour(specular, "specularColorFactor", 1.0, true);
  material.transmission = factors.unit(extension_of(place, "KHR_materials_transmission"), "transmissionFactor", 0.0);
  read_volume(place, factors, material, notes);
  read_priority(place, material, notes);
  material.dispersion = factors.clamped(number_of(extension_of(place, kDispersionExtension), "dispersion", 0.0),
                                        "dispersion", 0.0, kMaxDispersion);
  read_layers(place, factors, material);
  read_microfacets(place, factors, material);
  read_translucence(place, factors, material);
  if (material.phong && material.conductor)
    place.refuse("it has EIKON_materials_phong and EIKON_materials_conductor; leave one out");
  if (material.phong) material.metallic = material.transmission = material.diffuse_transmission = 0.0F;
  if (material.conductor) {
    material.metallic = 1.0F;
    material.transmission = material.diffuse_transmission = 0.0F;
  }
  read_measured(place, material);
  if (extension_of(place, "KHR_materials_unlit") != nullptr) {
    // The base colour and the alpha are all that is left of it [KHR_materials_unlit]; and it lights nothing.
    material.unlit = true;
    material.emission = glm::vec3(0.0F);
    material.transmission = material.diffuse_transmission = 0.0F;
    material.clearcoat = material.iridescence = 0.0F;
    material.anisotropy = 0.0F;
    material.conductor.reset();
    material.phong.reset();
    material.sheen_color = glm::vec3(0.0F);
  }
  return material;
}

void complete_material(const Json& document, std::size_t index, TextureReader& textures, Material& material,
                       Notes& notes) {
  const Place place = place_of(document, index);
  const Json* pbr = member(place.value, kPbr);
  const auto part = [&](const char* name, const char* key, bool srgb, bool counts) {
    const Json* json = name == std::string_view(kPbr) ? pbr : extension_of(place, name);
    return json != nullptr && counts ? textures.find({.value = *json, .kind = name, .parent = &place}, key, srgb)
                                     : std::nullopt;
  };
  const auto own = [&](const char* key, bool srgb, bool counts) {
    return counts ? textures.find(place, key, srgb) : std::nullopt;
  };
  const bool lit = !material.unlit;
  material.base_color_texture = part(kPbr, "baseColorTexture", true, true);
  material.metallic_roughness_texture =
      part(kPbr, "metallicRoughnessTexture", false, lit && (material.metallic > 0 || material.roughness > 0));
  material.emissive_texture = own("emissiveTexture", true, material.emission != glm::vec3(0.0F));
  material.transmission_texture =
      part("KHR_materials_transmission", "transmissionTexture", false, material.transmission > 0);
  const bool reflects = lit && material.specular > 0 && material.metallic < 1;
  material.specular_texture = part("KHR_materials_specular", "specularTexture", false, reflects);
  material.specular_color_texture = part("KHR_materials_specular", "specularColorTexture", true,
                                         reflects && material.specular_color != glm::vec3(0.0F));
  if (const Json* normal = member(place.value, "normalTexture")) {
    material.normal_scale = normal_scale_of(place, *normal, "normalTexture");
    material.normal_texture = own("normalTexture", false, lit && material.normal_scale != 0);
  }
  complete_layers(place, textures, material);
  complete_translucence(place, textures, material);
  if (lit) complete_microfacets(place, textures, material);
  // occlusionTexture is shadow baked for renderers that cannot see it; rays do, so it is left out on purpose and not named.
  // thicknessTexture: see read_volume.

  const Json* extensions = member(place.value, "extensions");
  if (extensions == nullptr) return;
  for (const auto& entry : extensions->items()) {
    if (std::find(kKnown.begin(), kKnown.end(), entry.key()) != kKnown.end()) continue;
    notes.unsupported(one_line(entry.key()), place.label());
  }
}

}  // namespace eikon
