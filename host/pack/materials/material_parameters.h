// SPDX-License-Identifier: Apache-2.0
// One row for each parameter of a material that its records hold as the scene has it.
#pragma once
#include <optional>
#include <span>
#include <variant>

#include "pack/features.h"
#include "shared/records.h"

namespace eikon {

using NumberOf = float Material::*;
using ColourOf = glm::vec3 Material::*;
using TextureOf = std::optional<Texture> Material::*;

/// The record of a material that has a parameter. Extensions and details exist only if some
/// material needs them.
enum class MaterialPart { record, extension, detail };

struct MaterialParameter {
  std::variant<NumberOf, ColourOf, TextureOf> from;
  MaterialPart part;
  std::size_t word;                      // of the part's record; a colour takes three
  std::optional<Feature> feature{};      // of textures: the programs with this feature look them up
  float Material::*scale = nullptr;      // of normal maps
};
[[nodiscard]] std::span<const MaterialParameter> material_parameters();

}  // namespace eikon
