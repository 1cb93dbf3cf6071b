// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/material_parameters.h"

#include <cstddef>

namespace eikon {
namespace {

#define EK_IN_RECORD(field) MaterialPart::record, offsetof(MaterialRecord, field) / 4
#define EK_IN_EXTENSION(field) MaterialPart::extension, offsetof(MaterialExtension, field) / 4
#define EK_IN_DETAIL(field) MaterialPart::detail, offsetof(MaterialDetail, field) / 4

const MaterialParameter kParameters[] = {
    {&Material::base_color, EK_IN_RECORD(base_color_r)},
    {&Material::metallic, EK_IN_RECORD(metallic)},
    {&Material::roughness, EK_IN_RECORD(roughness)},
    {&Material::ior, EK_IN_RECORD(ior)},
    {&Material::opacity, EK_IN_RECORD(opacity)},
    {&Material::alpha_cutoff, EK_IN_RECORD(alpha_cutoff)},
    {&Material::base_color_texture, EK_IN_RECORD(base_color_texture), Feature::base_color_texture},
    {&Material::metallic_roughness_texture, EK_IN_RECORD(metallic_roughness_texture),
     Feature::metallic_roughness_texture},
    {&Material::normal_texture, EK_IN_RECORD(normal_texture), Feature::normal_texture, &Material::normal_scale},
    {&Material::emissive_texture, EK_IN_RECORD(emissive_texture), Feature::emissive_texture},

    {&Material::specular, EK_IN_EXTENSION(specular)},
    {&Material::specular_color, EK_IN_EXTENSION(specular_color_r)},
    {&Material::transmission, EK_IN_EXTENSION(transmission)},
    {&Material::transmission_texture, EK_IN_EXTENSION(transmission_texture), Feature::transmission_texture},
    {&Material::specular_texture, EK_IN_EXTENSION(specular_texture), Feature::specular_texture},
    {&Material::specular_color_texture, EK_IN_EXTENSION(specular_color_texture), Feature::specular_texture},

    {&Material::clearcoat, EK_IN_DETAIL(clearcoat)},
    {&Material::clearcoat_roughness, EK_IN_DETAIL(clearcoat_roughness)},
    {&Material::clearcoat_texture, EK_IN_DETAIL(clearcoat_texture), Feature::clearcoat_texture},
    {&Material::clearcoat_roughness_texture, EK_IN_DETAIL(clearcoat_roughness_texture), Feature::clearcoat_texture},
    // A coat's normal map needs the same code as its material's.
    {&Material::clearcoat_normal_texture, EK_IN_DETAIL(clearcoat_normal_texture), Feature::normal_texture,
     &Material::clearcoat_normal_scale},
    {&Material::sheen_color, EK_IN_DETAIL(sheen_r)},
    {&Material::sheen_roughness, EK_IN_DETAIL(sheen_roughness)},
    {&Material::sheen_color_texture, EK_IN_DETAIL(sheen_color_texture), Feature::sheen_texture},
    {&Material::sheen_roughness_texture, EK_IN_DETAIL(sheen_roughness_texture), Feature::sheen_texture},
    {&Material::iridescence, EK_IN_DETAIL(iridescence)},
    {&Material::film_index, EK_IN_DETAIL(film_index)},
    {&Material::iridescence_texture, EK_IN_DETAIL(iridescence_texture), Feature::iridescence_texture},
    {&Material::film_thickness_texture, EK_IN_DETAIL(film_texture), Feature::iridescence_texture},
    {&Material::anisotropy, EK_IN_DETAIL(anisotropy)},
    {&Material::anisotropy_texture, EK_IN_DETAIL(anisotropy_texture), Feature::anisotropy_texture},
    {&Material::diffuse_transmission, EK_IN_DETAIL(diffuse_transmission)},
    {&Material::diffuse_transmission_color, EK_IN_DETAIL(diffuse_transmission_r)},
    {&Material::diffuse_transmission_texture, EK_IN_DETAIL(diffuse_transmission_texture),
     Feature::diffuse_transmission_texture},
    {&Material::diffuse_transmission_color_texture, EK_IN_DETAIL(diffuse_transmission_color_texture),
     Feature::diffuse_transmission_texture},
};

}  // namespace

std::span<const MaterialParameter> material_parameters() { return kParameters; }

}  // namespace eikon
