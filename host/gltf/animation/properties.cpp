// SPDX-License-Identifier: Apache-2.0
#include "gltf/animation/properties.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>  // values are written

#include "core/error.h"
#include "io/text.h"
#include "scene/limits.h"

namespace eikon {
namespace {

using enum ValueKind;

constexpr double kTiny = 1e-9;
constexpr double kWidestFov = 3.14159;  // below pi

// Cameras are refused for values out of range, so their ranges stand here; materials and lights
// bring their factors into theirs.
constexpr Property kProperties[] = {
    {"/nodes/*/translation", 3},
    {"/nodes/*/rotation", 4, rotation},
    {"/nodes/*/scale", 3},
    {"/nodes/*/weights", 0},
    {"/meshes/*/weights", 0},
    {"/nodes/*/weights/*"},
    {"/meshes/*/weights/*"},
    {"/nodes/*/extensions/KHR_node_visibility/visible", 1, boolean},
    {"/cameras/*/perspective/yfov", 1, numbers, kTiny, kWidestFov},
    {"/cameras/*/perspective/aspectRatio", 1, numbers, kMinAspect, kMaxAspect},
    {"/cameras/*/orthographic/xmag", 1, numbers, kTiny, 0x1p40},
    {"/cameras/*/orthographic/ymag", 1, numbers, kTiny, 0x1p40},
    {"/cameras/*/extensions/EIKON_camera_lens/radius", 1, numbers, kTiny, 0x1p40},
    {"/cameras/*/extensions/EIKON_camera_lens/fNumber", 1, numbers, kTiny, 0x1p40},
    {"/cameras/*/extensions/EIKON_camera_lens/focusDistance", 1, numbers, kTiny, 0x1p40},
    {"/extensions/KHR_lights_punctual/lights/*/color", 3},
    {"/extensions/KHR_lights_punctual/lights/*/intensity"},
    {"/extensions/KHR_lights_punctual/lights/*/range"},
    {"/extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle"},
    {"/extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle"},
    {"/materials/*/pbrMetallicRoughness/baseColorFactor", 4},
    {"/materials/*/pbrMetallicRoughness/metallicFactor"},
    {"/materials/*/pbrMetallicRoughness/roughnessFactor"},
    {"/materials/*/alphaCutoff"},
    {"/materials/*/emissiveFactor", 3},
    {"/materials/*/normalTexture/scale"},
    {"/materials/*/extensions/KHR_materials_anisotropy/anisotropyStrength"},
    {"/materials/*/extensions/KHR_materials_anisotropy/anisotropyRotation"},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatFactor"},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor"},
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale"},
    {"/materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor"},
    {"/materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", 3},
    {"/materials/*/extensions/KHR_materials_dispersion/dispersion"},
    {"/materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength"},
    {"/materials/*/extensions/KHR_materials_ior/ior"},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceFactor"},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceIor"},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum"},
    {"/materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum"},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", 4},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", 3},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor"},
    {"/materials/*/extensions/KHR_materials_sheen/sheenColorFactor", 3},
    {"/materials/*/extensions/KHR_materials_sheen/sheenRoughnessFactor"},
    {"/materials/*/extensions/KHR_materials_specular/specularFactor"},
    {"/materials/*/extensions/KHR_materials_specular/specularColorFactor", 3},
    {"/materials/*/extensions/KHR_materials_transmission/transmissionFactor"},
    {"/materials/*/extensions/KHR_materials_volume/thicknessFactor"},
    {"/materials/*/extensions/KHR_materials_volume/attenuationDistance"},
    {"/materials/*/extensions/KHR_materials_volume/attenuationColor", 3},
    {"/materials/*/extensions/EIKON_materials_phong/shininess"},
    {"/materials/*/extensions/EIKON_materials_phong/specular", 3},
    {"/materials/*/**/extensions/KHR_texture_transform/offset", 2},
    {"/materials/*/**/extensions/KHR_texture_transform/rotation"},
    {"/materials/*/**/extensions/KHR_texture_transform/scale", 2},
};

/// The names in a pointer; it begins with '/'. Those of glTF's properties have no '~' to unescape.
std::vector<std::string> names_of(std::string_view pointer) { return split(pointer.substr(1), '/'); }

bool matches(const std::vector<std::string>& pattern, std::size_t p, const std::vector<std::string>& names,
             std::size_t n) {
  if (p == pattern.size()) return n == names.size();
  if (n == names.size()) return false;
  if (pattern[p] == "**") return matches(pattern, p, names, n + 1) || matches(pattern, p + 1, names, n + 1);
  return (pattern[p] == "*" || pattern[p] == names[n]) && matches(pattern, p + 1, names, n + 1);
}

/// The element or member of this name; null if there is none.
Json* child_of(Json& owner, const std::string& name) {
  if (owner.is_array()) {
    const auto index = number_in<std::size_t>(name);
    return index && *index < owner.size() ? &owner[*index] : nullptr;
  }
  if (!owner.is_object()) return nullptr;
  const auto found = owner.find(name);
  return found == owner.end() ? nullptr : &*found;
}

/// True for a pointer to the weight of one morph target, which node and mesh may lack.
bool is_one_weight(const std::vector<std::string>& names) { return names.size() == 4 && names[2] == "weights"; }

/// Gives a node or mesh that lacks weights those that count for it.
void state_weights(Json& document, const std::string& list, std::size_t index, std::size_t count) {
  Json& weights = document[list][index]["weights"];
  if (weights.is_array() && weights.size() == count) return;
  const Json* of_mesh = nullptr;
  if (list == "nodes") of_mesh = member(document["meshes"][to_index(document[list][index]["mesh"])], "weights");
  const bool counts = of_mesh != nullptr && of_mesh->is_array() && of_mesh->size() == count;
  weights = counts ? Json(*of_mesh) : Json(std::vector<double>(count, 0.0));
}

/// A material may lack the object of its base, whose factors have defaults.
bool may_be_absent(const std::string& name) { return name == "pbrMetallicRoughness"; }

}  // namespace

const Property* find_property(std::string_view pointer) {
  constexpr std::size_t kMaxParts = 16;
  if (!pointer.starts_with('/')) return nullptr;
  const std::vector<std::string> names = names_of(pointer);
  if (names.size() > kMaxParts) return nullptr;
  const auto* const found = std::ranges::find_if(
      kProperties, [&](const Property& property) { return matches(names_of(property.pattern), 0, names, 0); });
  return found == std::end(kProperties) ? nullptr : found;
}

std::optional<std::size_t> weight_count(const Json& document, std::string_view pointer) {
  const std::vector<std::string> names = names_of(pointer);
  const auto element_of = [&](const char* key, std::size_t index) -> const Json* {
    const Json* const list = member(document, key);
    return list != nullptr && index < size_of(*list) ? &element(*list, index) : nullptr;
  };
  const auto index = number_in<std::size_t>(names[1]);
  if (!index) return std::nullopt;
  const Json* mesh = element_of(names[0].c_str(), *index);
  if (names[0] == "nodes") {
    const Json* const of_node = member(mesh, "mesh");
    if (of_node == nullptr) return std::nullopt;
    mesh = element_of("meshes", to_index(*of_node));
  }
  const Json* const primitives = member(mesh, "primitives");
  const Json* const targets =
      primitives == nullptr || size_of(*primitives) == 0 ? nullptr : member(element(*primitives, 0), "targets");
  return targets == nullptr ? std::nullopt : std::optional(size_of(*targets));
}

void check_pointer(const Json& document, std::string_view pointer) {
  const std::vector<std::string> names = names_of(pointer);
  if (is_one_weight(names)) {
    const auto number = number_in<std::size_t>(names[3]);
    const std::size_t count = weight_count(document, pointer).value_or(0);
    if (number && *number < count) return;
    throw InputError(fmt::format("{} leads to nothing: there are {} morph targets", in_quotes(pointer), count));
  }
  Json* owner = const_cast<Json*>(&document);  // child_of changes nothing
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    Json* const next = child_of(*owner, names[i]);
    const bool is_last = i + 2 == names.size();
    if (next == nullptr && is_last && may_be_absent(names[i])) return;
    if (next == nullptr || !(next->is_object() || (next->is_array() && !is_last)))
      throw InputError(fmt::format("{} leads to nothing: there is no {}", in_quotes(pointer), in_quotes(names[i])));
    owner = next;
  }
}

bool write_property(Json& document, std::string_view pointer, const Property& property,
                    const std::vector<double>& value) {
  const std::vector<std::string> names = names_of(pointer);
  if (is_one_weight(names))
    state_weights(document, names[0], *number_in<std::size_t>(names[1]), weight_count(document, pointer).value_or(0));
  Json* owner = &document;
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    Json* const next = child_of(*owner, names[i]);
    owner = next != nullptr ? next : &((*owner)[names[i]] = Json::object());
  }
  Json& place = owner->is_array() ? (*owner)[*number_in<std::size_t>(names.back())] : (*owner)[names.back()];
  if (property.kind == boolean) {
    place = value[0] != 0;
    return true;
  }
  std::vector<double> legal = value;
  for (double& number : legal) number = std::clamp(number, property.least, property.most);
  if (property.width == 1)
    place = legal[0];
  else
    place = legal;
  return legal == value;
}

}  // namespace eikon
