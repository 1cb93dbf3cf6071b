// SPDX-License-Identifier: Apache-2.0
// What lies on a material, and light that it scatters through: KHR_materials_clearcoat, _sheen,
// _iridescence and _diffuse_transmission.
#include "gltf/document/document_check.h"
#include "gltf/materials/material_extensions.h"

namespace eikon {
namespace {

void check_clearcoat(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "clearcoatFactor");
  as_number(extension, "clearcoatRoughnessFactor");
  for (const char* slot : {"clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"})
    check_texture_slot(extension, slot, texture_count);
}

void read_clearcoat(const JsonView& extension, const Factors& factors, Material& material) {
  material.clearcoat = factors.unit(&extension.value, "clearcoatFactor", 0.0);
  material.clearcoat_roughness = factors.unit(&extension.value, "clearcoatRoughnessFactor", 0.0);
}

void find_clearcoat_textures(const JsonView& extension, TextureReader& textures, Material& material) {
  const bool coated = material.clearcoat > 0;
  if (coated) material.clearcoat_texture = textures.find(extension, "clearcoatTexture", false);
  if (coated && material.clearcoat_roughness > 0)
    material.clearcoat_roughness_texture = textures.find(extension, "clearcoatRoughnessTexture", false);
  const char* key = "clearcoatNormalTexture";
  const Json* const normal = member(extension.value, key);
  if (normal == nullptr) return;
  material.clearcoat_normal_scale = normal_scale_of(*extension.parent, *normal, key);
  if (coated && material.clearcoat_normal_scale != 0)
    material.clearcoat_normal_texture = textures.find(extension, key, false);
}

void check_sheen(const JsonView& extension, std::size_t texture_count) {
  has_numbers(extension, "sheenColorFactor", 3);
  as_number(extension, "sheenRoughnessFactor");
  for (const char* slot : {"sheenColorTexture", "sheenRoughnessTexture"})
    check_texture_slot(extension, slot, texture_count);
}

void read_sheen(const JsonView& extension, const Factors& factors, Material& material) {
  material.sheen_color = factors.color(&extension.value, "sheenColorFactor", 0.0);
  material.sheen_roughness = factors.unit(&extension.value, "sheenRoughnessFactor", 0.0);
}

void find_sheen_textures(const JsonView& extension, TextureReader& textures, Material& material) {
  if (material.sheen_color == glm::vec3(0.0F)) return;
  material.sheen_color_texture = textures.find(extension, "sheenColorTexture", true);
  if (material.sheen_roughness > 0)
    material.sheen_roughness_texture = textures.find(extension, "sheenRoughnessTexture", false);
}

void check_iridescence(const JsonView& extension, std::size_t texture_count) {
  for (const char* number :
       {"iridescenceFactor", "iridescenceIor", "iridescenceThicknessMinimum", "iridescenceThicknessMaximum"})
    as_number(extension, number);
  for (const char* slot : {"iridescenceTexture", "iridescenceThicknessTexture"})
    check_texture_slot(extension, slot, texture_count);
}

void read_iridescence(const JsonView& extension, const Factors& factors, Material& material) {
  constexpr double kThickest_nm = 1e5;  // colours have faded long before
  const auto in_range = [&](const char* key, double otherwise, double lo, double hi) {
    return factors.clamped(number_of(&extension.value, key, otherwise), key, lo, hi);
  };
  material.iridescence = factors.unit(&extension.value, "iridescenceFactor", 0.0);
  material.thin_film_index = in_range("iridescenceIor", 1.3, 1.0, 1e3);
  material.thin_film_thickness_nm[0] = in_range("iridescenceThicknessMinimum", 100.0, 0.0, kThickest_nm);
  material.thin_film_thickness_nm[1] = in_range("iridescenceThicknessMaximum", 400.0, 0.0, kThickest_nm);
}

void find_iridescence_textures(const JsonView& extension, TextureReader& textures, Material& material) {
  if (!(material.iridescence > 0)) return;
  material.iridescence_texture = textures.find(extension, "iridescenceTexture", false);
  if (material.thin_film_thickness_nm[0] != material.thin_film_thickness_nm[1])
    material.thin_film_thickness_texture = textures.find(extension, "iridescenceThicknessTexture", false);
}

void check_diffuse_transmission(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "diffuseTransmissionFactor");
  has_numbers(extension, "diffuseTransmissionColorFactor", 3);
  for (const char* slot : {"diffuseTransmissionTexture", "diffuseTransmissionColorTexture"})
    check_texture_slot(extension, slot, texture_count);
}

void read_diffuse_transmission(const JsonView& extension, const Factors& factors, Material& material) {
  material.diffuse_transmission = factors.unit(&extension.value, "diffuseTransmissionFactor", 0.0);
  material.diffuse_transmission_color = factors.color(&extension.value, "diffuseTransmissionColorFactor", 1.0);
}

void find_diffuse_transmission_textures(const JsonView& extension, TextureReader& textures, Material& material) {
  if (!(material.diffuse_transmission > 0)) return;
  material.diffuse_transmission_texture = textures.find(extension, "diffuseTransmissionTexture", false);
  if (material.diffuse_transmission_color != glm::vec3(0.0F))
    material.diffuse_transmission_color_texture = textures.find(extension, "diffuseTransmissionColorTexture", true);
}

constexpr MaterialExtensionReader kLayersExtensions[] = {
    {.name = "KHR_materials_clearcoat",
     .check = check_clearcoat,
     .read = read_clearcoat,
     .find_textures = find_clearcoat_textures},
    {.name = "KHR_materials_sheen", .check = check_sheen, .read = read_sheen, .find_textures = find_sheen_textures},
    {.name = "KHR_materials_iridescence",
     .check = check_iridescence,
     .read = read_iridescence,
     .find_textures = find_iridescence_textures},
    {.name = "KHR_materials_diffuse_transmission",
     .check = check_diffuse_transmission,
     .read = read_diffuse_transmission,
     .find_textures = find_diffuse_transmission_textures},
};

}  // namespace

std::span<const MaterialExtensionReader> layer_extensions() { return kLayersExtensions; }

}  // namespace eikon
