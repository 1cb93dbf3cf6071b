// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_translucence.h"

namespace eikon {
namespace {

constexpr const char *kFactor = "diffuseTransmissionFactor", *kColor = "diffuseTransmissionColorFactor",
                     *kTexture = "diffuseTransmissionTexture", *kColorTexture = "diffuseTransmissionColorTexture";

}  // namespace

bool check_translucence(const Place& extension, std::size_t texture_count) {
  if (extension.kind != kTranslucenceExtension) return false;
  as_number(extension, kFactor);
  has_numbers(extension, kColor, 3);
  check_texture_slot(extension, kTexture, texture_count);
  check_texture_slot(extension, kColorTexture, texture_count);
  return true;
}

void read_translucence(const Place& place, const Factors& factors, Material& material) {
  const Json* json = extension_of(place, kTranslucenceExtension);
  material.diffuse_transmission = factors.unit(json, kFactor, 0.0);
  material.diffuse_transmission_color = factors.colour(json, kColor, 1.0);
}

void complete_translucence(const Place& place, TextureReader& textures, Material& material) {
  const Json* json = extension_of(place, kTranslucenceExtension);
  if (json == nullptr || !(material.diffuse_transmission > 0)) return;
  const Place extension{.value = *json, .kind = kTranslucenceExtension, .parent = &place};
  material.diffuse_transmission_texture = textures.find(extension, kTexture, false);
  if (material.diffuse_transmission_color != glm::vec3(0.0F))
    material.diffuse_transmission_color_texture = textures.find(extension, kColorTexture, true);
}

}  // namespace eikon
