// SPDX-License-Identifier: Apache-2.0
// What lies on a material: KHR_materials_clearcoat, KHR_materials_sheen, KHR_materials_iridescence.
#pragma once
#include <string_view>

#include "gltf/materials/material_factors.h"
#include "gltf/materials/textures.h"

namespace eikon {

inline constexpr std::string_view kClearcoatExtension = "KHR_materials_clearcoat";
inline constexpr std::string_view kSheenExtension = "KHR_materials_sheen";
inline constexpr std::string_view kIridescenceExtension = "KHR_materials_iridescence";

/// Whether `extension` is one of the three; if so its types are checked. throws InputError naming what is wrong with it
bool check_layers(const Place& extension, std::size_t texture_count);

/// Factors of a checked material.
void read_layers(const Place& place, const Factors& factors, Material& material);

/// Their textures, but for those whose factor is 0. throws InputError as TextureReader::find
void complete_layers(const Place& place, TextureReader& textures, Material& material);

}  // namespace eikon
