// SPDX-License-Identifier: Apache-2.0
// Light that passes a surface and is scattered by it: KHR_materials_diffuse_transmission.
#pragma once
#include <string_view>

#include "gltf/materials/material_factors.h"
#include "gltf/materials/textures.h"

namespace eikon {

inline constexpr std::string_view kTranslucenceExtension = "KHR_materials_diffuse_transmission";

/// Whether `extension` is that one; if so its types are checked. throws InputError naming what is wrong with it
bool check_translucence(const Place& extension, std::size_t texture_count);

/// Factors of a checked material.
void read_translucence(const Place& place, const Factors& factors, Material& material);

/// Its textures, but for those whose factor is 0. throws InputError as TextureReader::find
void complete_translucence(const Place& place, TextureReader& textures, Material& material);

}  // namespace eikon
