// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string_view>

#include "gltf/materials/material_factors.h"
#include "gltf/materials/textures.h"

namespace eikon {

inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

/// An extension of materials: a row in the table of its group. What an extension does not need is
/// null.
struct MaterialExtensionReader {
  const char* name;
  /// Checks the types of its members. throws InputError naming what is wrong with them
  void (*check)(const JsonView& extension, std::size_t texture_count) = nullptr;
  /// Reads its factors, once the material's own and those of the rows above are known.
  void (*read)(const JsonView& extension, const Factors& factors, Material& material) = nullptr;
  /// Finds its textures, but for those whose factor is 0, once the material is used. throws
  /// InputError as TextureReader::find
  void (*find_textures)(const JsonView& extension, TextureReader& textures, Material& material) = nullptr;
};

// The groups in the order in which they are read. Extensions that replace others come after them,
// and the last group takes back what does not apply. The order in which textures are found is part
// of the scene's hash, so rows with textures keep theirs.
[[nodiscard]] std::span<const MaterialExtensionReader> dielectric_extensions();
[[nodiscard]] std::span<const MaterialExtensionReader> specular_glossiness_extensions();
[[nodiscard]] std::span<const MaterialExtensionReader> layer_extensions();
[[nodiscard]] std::span<const MaterialExtensionReader> microfacet_extensions();
[[nodiscard]] std::span<const MaterialExtensionReader> measured_extensions();
[[nodiscard]] std::span<const MaterialExtensionReader> emission_extensions();

/// The row of this name, or null if eikon does not read it.
[[nodiscard]] const MaterialExtensionReader* find_material_extension(std::string_view name);

/// throws InputError naming what is wrong with one of a material's extensions
void check_material_extensions(const JsonView& material, std::size_t texture_count);

/// Reads the factors of all extensions of a checked material.
void read_material_extensions(const JsonView& view, const Factors& factors, Material& material);

/// Finds the textures of all extensions of a checked material. throws InputError as
/// TextureReader::find
void find_extension_textures(const JsonView& view, TextureReader& textures, Material& material);

}  // namespace eikon
