// SPDX-License-Identifier: Apache-2.0
// KHR_materials_pbrSpecularGlossiness, archived: what materials were before metallic-roughness, and
// what counts where a material has both. Nothing is approximated: eikon's dielectric with an
// infinite index (KHR_materials_ior's 0) reflects at normal incidence what its specular colour says
// (KHR_materials_specular), over a diffuse base that gets the rest. That is the extension's
//   diffuse (1 - max(specular)) / pi + GGX with F0 = specular, F90 = 1, alpha = (1 - glossiness)^2
// but for the share that the layer takes from the base, which is its albedo in both directions
// instead of the constant max(specular).
#include <algorithm>

#include "gltf/document/document_check.h"
#include "gltf/materials/material_extensions.h"

namespace eikon {
namespace {

void check_glossy(const JsonView& extension, std::size_t texture_count) {
  has_numbers(extension, "diffuseFactor", 4);
  has_numbers(extension, "specularFactor", 3);
  as_number(extension, "glossinessFactor");
  for (const char* slot : {"diffuseTexture", "specularGlossinessTexture"})
    check_texture_slot(extension, slot, texture_count);
}

float glossiness_of(const JsonView& extension) {
  return static_cast<float>(std::clamp(number_of(&extension.value, "glossinessFactor", 1.0), 0.0, 1.0));
}

void read_glossy(const JsonView& extension, const Factors& factors, Material& material) {
  const Json* const glossy = &extension.value;
  material.base_color = factors.color(glossy, "diffuseFactor", 1.0);
  const Json* const rgba = member(glossy, "diffuseFactor");
  material.opacity = rgba == nullptr ? 1.0F : factors.clamped(number_at(*rgba, 3), "diffuseFactor", 0.0, 1.0);
  material.roughness = 1.0F - factors.unit(glossy, "glossinessFactor", 1.0);
  material.metallic = material.transmission = 0.0F;
  material.ior = 0.0F;
  material.specular = 1.0F;
  material.specular_color = factors.color(glossy, "specularFactor", 1.0);
}

void find_glossy_textures(const JsonView& extension, TextureReader& textures, Material& material) {
  material.base_color_texture = textures.find(extension, "diffuseTexture", true);
  const float glossiness = glossiness_of(extension);
  const bool colored = material.specular_color != glm::vec3(0.0F);
  if (material.unlit || (!colored && glossiness == 0.0F)) return;
  const auto texture = textures.find(extension, "specularGlossinessTexture", true);
  if (!texture) return;
  if (colored) material.specular_color_texture = texture;
  if (glossiness == 0.0F) return;
  material.metallic_roughness_texture = textures.roughness_of(*texture, glossiness);
  material.roughness = 1.0F;
}

constexpr MaterialExtensionReader kSpecularGlossinessExtensions[] = {
    {.name = kSpecularGlossiness, .check = check_glossy, .read = read_glossy, .find_textures = find_glossy_textures},
};

}  // namespace

std::span<const MaterialExtensionReader> specular_glossiness_extensions() { return kSpecularGlossinessExtensions; }

}  // namespace eikon
