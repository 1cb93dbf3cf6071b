// SPDX-License-Identifier: Apache-2.0
// How a material's microfacets lie and reflect: KHR_materials_anisotropy, EIKON_materials_conductor.
#pragma once
#include <string_view>

#include "gltf/materials/material_factors.h"
#include "gltf/materials/textures.h"

namespace eikon {

inline constexpr std::string_view kAnisotropyExtension = "KHR_materials_anisotropy";
inline constexpr std::string_view kConductorExtension = "EIKON_materials_conductor";
inline constexpr std::string_view kPhongExtension = "EIKON_materials_phong";

/// Whether `extension` is one of the three; if so its types are checked, and the name of its metal.
/// throws InputError naming what is wrong with it
bool check_microfacets(const Place& extension, std::size_t texture_count);

/// Factors of a checked material.
void read_microfacets(const Place& place, const Factors& factors, Material& material);

/// Their texture, unless its factor is 0. throws InputError as TextureReader::find
void complete_microfacets(const Place& place, TextureReader& textures, Material& material);

}  // namespace eikon
