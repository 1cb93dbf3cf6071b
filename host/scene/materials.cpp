// SPDX-License-Identifier: Apache-2.0
#include "scene/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace eikon {
namespace {

constexpr const char* kMetallic = "metallic reflection (rendered as diffuse)";
constexpr const char* kSpecular = "specular reflection";

std::string material_label(const tinygltf::Model& model, std::size_t index) {
  return label("material", index, model.materials[index].name);
}

/// Brings a factor of one material into [0, 1].
class Clamp {
 public:
  Clamp(std::string user, Notes& notes) : user_(std::move(user)), notes_(notes) {}

  float unit(double value, std::string_view what) const {
    const double legal = std::clamp(value, 0.0, 1.0);
    if (legal != value) notes_.warn(fmt::format("{}: {} {:g} clamped to {:g}", user_, what, value, legal));
    return static_cast<float>(legal);
  }

  glm::vec3 unit3(const std::vector<double>& rgb, std::string_view what) const {
    return {unit(rgb[0], what), unit(rgb[1], what), unit(rgb[2], what)};
  }

 private:
  std::string user_;
  Notes& notes_;
};

// A number of a material's extension, straight from the document: tinygltf keeps large integers there in 32 bits.
double extension_number(const Json& document, std::size_t index, const char* extension, const char* key,
                        double otherwise) {
  const Json& material = document["materials"][index];
  const Json* extensions = member(material, "extensions");
  const Json* found = extensions == nullptr ? nullptr : member(*extensions, extension);
  const Json* number = found == nullptr ? nullptr : member(*found, key);
  return number == nullptr ? otherwise : number->get<double>();
}

glm::vec3 emission_of(const tinygltf::Model& model, const Json& document, std::size_t index, const Clamp& clamp,
                      Notes& notes) {
  const glm::vec3 factor = clamp.unit3(model.materials[index].emissiveFactor, "emissiveFactor");
  const std::string user = material_label(model, index);
  double strength = extension_number(document, index, "KHR_materials_emissive_strength", "emissiveStrength", 1.0);
  if (strength < 0) {
    notes.warn(fmt::format("{}: emissiveStrength {:g} clamped to 0", user, strength));
    strength = 0;
  }
  glm::vec3 emission{0.0F};
  for (int c = 0; c < 3; ++c) {
    const double radiance = static_cast<double>(factor[c]) * strength;
    if (!(radiance <= static_cast<double>(std::numeric_limits<float>::max()))) {
      throw InputError(
          fmt::format("{}: emissiveStrength {:g} is beyond single precision; use a smaller unit", user, strength));
    }
    emission[c] = static_cast<float>(radiance);
  }
  return emission;
}

}  // namespace

Material convert_material(const tinygltf::Model& model, const Json& document, std::size_t index, Notes& notes) {
  const tinygltf::Material& source = model.materials[index];
  const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
  const Clamp clamp(material_label(model, index), notes);
  Material material;
  material.name = source.name;
  material.base_color = clamp.unit3(pbr.baseColorFactor, "baseColorFactor");
  material.metallic = clamp.unit(pbr.metallicFactor, "metallicFactor");
  material.roughness = clamp.unit(pbr.roughnessFactor, "roughnessFactor");
  material.specular =
      clamp.unit(extension_number(document, index, "KHR_materials_specular", "specularFactor", 1.0), "specularFactor");
  material.emission = emission_of(model, document, index, clamp, notes);
  material.double_sided = source.doubleSided;
  if (source.alphaMode != "OPAQUE" && source.alphaMode != "MASK" && source.alphaMode != "BLEND") {
    notes.warn(fmt::format("{}: alphaMode {} is none of OPAQUE, MASK, BLEND; taken as OPAQUE",
                           material_label(model, index), in_quotes(source.alphaMode)));
  }
  return material;
}

void note_unsupported(const tinygltf::Model& model, const Json& document, std::size_t index, const Material& material,
                      Notes& notes) {
  const std::string user = material_label(model, index);
  const Json& json = document["materials"][index];
  const auto note_textures = [&](const Json* owner) {
    if (owner == nullptr) return;
    for (const auto& entry : owner->items()) {
      if (entry.key().ends_with("Texture")) notes.unsupported("texture " + one_line(entry.key()), user);
    }
  };
  note_textures(member(json, "pbrMetallicRoughness"));
  note_textures(&json);
  const std::string& alpha_mode = model.materials[index].alphaMode;
  if (alpha_mode == "MASK" || alpha_mode == "BLEND") notes.unsupported("alphaMode " + alpha_mode, user);
  if (material.metallic > 0) notes.unsupported(kMetallic, user);
  if (material.metallic < 1 && material.specular > 0) notes.unsupported(kSpecular, user);
  const Json* extensions = member(json, "extensions");
  if (extensions == nullptr) return;
  for (const auto& entry : extensions->items()) {
    if (entry.key() == "KHR_materials_specular") {
      note_textures(&entry.value());
    } else if (entry.key() != "KHR_materials_emissive_strength") {
      notes.unsupported(one_line(entry.key()), user);
    }
  }
}

Material default_material(Notes& notes) {
  notes.unsupported(kMetallic, "the default material");
  return {};
}

}  // namespace eikon
