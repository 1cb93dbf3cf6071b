// SPDX-License-Identifier: Apache-2.0
// The surface and inside of dielectrics: KHR_materials_ior, _specular, _transmission, _volume and
// _dispersion.
#include <fmt/format.h>

#include <algorithm>

#include "gltf/document/document_check.h"
#include "gltf/materials/material_extensions.h"

namespace eikon {
namespace {

constexpr double kMaxDispersion = 39;  // from 40 on the index of R would be 1 or less
constexpr double kMaxIor = 1e9;        // reflects all but 4e-9; squares stay finite

void check_ior(const JsonView& extension, std::size_t) { as_number(extension, "ior"); }

void read_ior(const JsonView& extension, const Factors& factors, Material& material) {
  const double ior = number_of(&extension.value, "ior", 1.5);
  material.ior = ior == 0 ? 0.0F : factors.clamped(ior, "ior", 1.0, kMaxIor);
}

void check_specular(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "specularFactor");
  has_numbers(extension, "specularColorFactor", 3);
  check_texture_slot(extension, "specularTexture", texture_count);
  check_texture_slot(extension, "specularColorTexture", texture_count);
}

void read_specular(const JsonView& extension, const Factors& factors, Material& material) {
  material.specular = factors.unit(&extension.value, "specularFactor", 1.0);
  material.specular_color = factors.color(&extension.value, "specularColorFactor", 1.0, true);
}

void check_transmission(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "transmissionFactor");
  check_texture_slot(extension, "transmissionTexture", texture_count);
}

void read_transmission(const JsonView& extension, const Factors& factors, Material& material) {
  material.transmission = factors.unit(&extension.value, "transmissionFactor", 0.0);
}

void check_volume(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "thicknessFactor");
  check_texture_slot(extension, "thicknessTexture", texture_count);
  as_number(extension, "attenuationDistance");
  has_numbers(extension, "attenuationColor", 3);
}

// Only the sign of the thickness counts, since rays find the other side by themselves; so
// thicknessTexture is not read.
void read_volume(const JsonView& extension, const Factors& factors, Material& material) {
  const Json* const volume = &extension.value;
  material.solid = factors.not_negative(number_of(volume, "thicknessFactor", 0.0), "thicknessFactor") > 0;
  material.attenuation_color = factors.color(volume, "attenuationColor", 1.0);
  const char* key = "attenuationDistance";
  if (member(volume, key) == nullptr) return;
  const double distance = number_of(volume, key, 0.0);
  if (!(distance > 0)) {
    factors.warn(fmt::format("{} {:g} is not positive; taken as infinite", key, distance));
  } else if (distance <= kMaxFloat) {
    material.attenuation_distance = static_cast<float>(std::max(distance, kMinFloat));
  }
}

void check_dispersion(const JsonView& extension, std::size_t) { as_number(extension, "dispersion"); }

void read_dispersion(const JsonView& extension, const Factors& factors, Material& material) {
  material.dispersion =
      factors.clamped(number_of(&extension.value, "dispersion", 0.0), "dispersion", 0.0, kMaxDispersion);
}

// materials.cpp finds the textures of `specular` and `transmission`: in the scene's hash they stand
// before the normal map.
constexpr MaterialExtensionReader kDielectricExtensions[] = {
    {.name = "KHR_materials_ior", .check = check_ior, .read = read_ior},
    {.name = "KHR_materials_specular", .check = check_specular, .read = read_specular},
    {.name = "KHR_materials_transmission", .check = check_transmission, .read = read_transmission},
    {.name = "KHR_materials_volume", .check = check_volume, .read = read_volume},
    {.name = "KHR_materials_dispersion", .check = check_dispersion, .read = read_dispersion},
};

}  // namespace

std::span<const MaterialExtensionReader> dielectric_extensions() { return kDielectricExtensions; }

}  // namespace eikon
