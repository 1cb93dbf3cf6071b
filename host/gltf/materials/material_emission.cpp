// SPDX-License-Identifier: Apache-2.0
// The light that a material gives off: KHR_materials_emissive_strength and KHR_materials_unlit.
#include <fmt/format.h>

#include "gltf/materials/material_extensions.h"

namespace eikon {
namespace {

void check_strength(const JsonView& extension, std::size_t) { as_number(extension, "emissiveStrength"); }

void read_strength(const JsonView& extension, const Factors& factors, Material& material) {
  const char* key = "emissiveStrength";
  const double strength = number_of(&extension.value, key, 1.0);
  const double legal = strength < 0 ? static_cast<double>(factors.clamped(strength, key, 0.0, 0.0)) : strength;
  for (int c = 0; c < 3; ++c) {
    const double radiance = static_cast<double>(material.emission[c]) * legal;
    if (!(radiance <= kMaxFloat))
      factors.material().refuse(
          fmt::format("emissiveStrength {:g} is beyond single precision; use a smaller unit", strength));
    material.emission[c] = static_cast<float>(radiance);
  }
}

// The base colour and the alpha are all that is left of an unlit material [KHR_materials_unlit];
// and it lights nothing.
void read_unlit(const JsonView&, const Factors&, Material& material) {
  material.unlit = true;
  material.emission = glm::vec3(0.0F);
  material.transmission = material.diffuse_transmission = 0.0F;
  material.clearcoat = material.iridescence = 0.0F;
  material.anisotropy = 0.0F;
  material.lobe.reset();
  material.sheen_color = glm::vec3(0.0F);
}

constexpr MaterialExtensionReader kEmissionExtensions[] = {
    {.name = "KHR_materials_emissive_strength", .check = check_strength, .read = read_strength},
    {.name = "KHR_materials_unlit", .read = read_unlit},
};

}  // namespace

std::span<const MaterialExtensionReader> emission_extensions() { return kEmissionExtensions; }

}  // namespace eikon
