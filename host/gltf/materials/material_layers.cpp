// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_layers.h"

#include <initializer_list>
#include <optional>

namespace eikon {

bool check_layers(const Place& extension, std::size_t texture_count) {
  const auto textures = [&](std::initializer_list<const char*> slots) {
    for (const char* slot : slots) check_texture_slot(extension, slot, texture_count);
  };
  if (extension.kind == kClearcoatExtension) {
    as_number(extension, "clearcoatFactor");
    as_number(extension, "clearcoatRoughnessFactor");
    textures({"clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"});
    return true;
  }
  if (extension.kind == kIridescenceExtension) {
    for (const char* number :
         {"iridescenceFactor", "iridescenceIor", "iridescenceThicknessMinimum", "iridescenceThicknessMaximum"})
      as_number(extension, number);
    textures({"iridescenceTexture", "iridescenceThicknessTexture"});
    return true;
  }
  if (extension.kind != kSheenExtension) return false;
  has_numbers(extension, "sheenColorFactor", 3);
  as_number(extension, "sheenRoughnessFactor");
  textures({"sheenColorTexture", "sheenRoughnessTexture"});
  return true;
}

void read_layers(const Place& place, const Factors& factors, Material& material) {
  const Json* coat = extension_of(place, kClearcoatExtension);
  material.clearcoat = factors.unit(coat, "clearcoatFactor", 0.0);
  material.clearcoat_roughness = factors.unit(coat, "clearcoatRoughnessFactor", 0.0);
  const Json* sheen = extension_of(place, kSheenExtension);
  material.sheen_color = factors.colour(sheen, "sheenColorFactor", 0.0);
  material.sheen_roughness = factors.unit(sheen, "sheenRoughnessFactor", 0.0);
  const Json* film = extension_of(place, kIridescenceExtension);
  constexpr double kThickest_nm = 1e5;  // colours have faded long before
  material.iridescence = factors.unit(film, "iridescenceFactor", 0.0);
  material.film_index = factors.clamped(number_of(film, "iridescenceIor", 1.3), "iridescenceIor", 1.0, 1e3);
  material.film_thickness_nm[0] = factors.clamped(number_of(film, "iridescenceThicknessMinimum", 100.0),
                                                  "iridescenceThicknessMinimum", 0.0, kThickest_nm);
  material.film_thickness_nm[1] = factors.clamped(number_of(film, "iridescenceThicknessMaximum", 400.0),
                                                  "iridescenceThicknessMaximum", 0.0, kThickest_nm);
}

void complete_layers(const Place& place, TextureReader& textures, Material& material) {
  const auto texture = [&](std::string_view extension, const char* key, bool srgb, bool counts) {
    const Json* json = extension_of(place, extension);
    return json != nullptr && counts ? textures.find({.value = *json, .kind = extension, .parent = &place}, key, srgb)
                                     : std::nullopt;
  };
  const bool coated = material.clearcoat > 0;
  material.clearcoat_texture = texture(kClearcoatExtension, "clearcoatTexture", false, coated);
  material.clearcoat_roughness_texture =
      texture(kClearcoatExtension, "clearcoatRoughnessTexture", false, coated && material.clearcoat_roughness > 0);
  const Json* coat = extension_of(place, kClearcoatExtension);
  if (const Json* normal = coat == nullptr ? nullptr : member(*coat, "clearcoatNormalTexture")) {
    material.clearcoat_normal_scale = normal_scale_of(place, *normal, "clearcoatNormalTexture");
    material.clearcoat_normal_texture =
        texture(kClearcoatExtension, "clearcoatNormalTexture", false, coated && material.clearcoat_normal_scale != 0);
  }
  const bool fuzzy = material.sheen_color != glm::vec3(0.0F);
  material.sheen_color_texture = texture(kSheenExtension, "sheenColorTexture", true, fuzzy);
  material.sheen_roughness_texture =
      texture(kSheenExtension, "sheenRoughnessTexture", false, fuzzy && material.sheen_roughness > 0);
  const bool filmy = material.iridescence > 0;
  material.iridescence_texture = texture(kIridescenceExtension, "iridescenceTexture", false, filmy);
  material.film_thickness_texture = texture(kIridescenceExtension, "iridescenceThicknessTexture", false,
                                            filmy && material.film_thickness_nm[0] != material.film_thickness_nm[1]);
}

}  // namespace eikon
