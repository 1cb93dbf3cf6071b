// SPDX-License-Identifier: Apache-2.0
// How a material's microfacets lie and reflect: KHR_materials_anisotropy, EIKON_materials_phong,
// EIKON_materials_conductor.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "gltf/document/document_check.h"
#include "gltf/materials/material_extensions.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr double kMaxShininess = 1e4;  // floats resolve no narrower highlights
constexpr double kMaxIndex = 0x1p14;   // its fourth power stays finite in the kernels

// Indices of refraction at 650, 550 and 450 nm, which stand for R, G and B: they are the middles of
// what the three primaries see. Each is of one wavelength, so that the reflectance is the metal's
// own there; a mean over a primary's band would be of no wavelength.
// source  luxpop.com's tables (Palik, Handbook of Optical Constants of Solids; Johnson and Christy
//         1972), interpolated linearly
struct Metal {
  std::string_view name;
  glm::vec3 eta, k;
};
constexpr std::array<Metal, 10> kMetals{{
    {"Ag", {0.13941F, 0.124777F, 0.151691F}, {4.128773F, 3.3396F, 2.47042F}},
    {"Al", {1.47477F, 0.958569F, 0.617953F}, {7.794109F, 6.686968F, 5.469423F}},
    {"Au", {0.16779F, 0.350409F, 1.508458F}, {3.137816F, 2.714063F, 1.87885F}},
    {"Cr", {3.637546F, 3.115763F, 1.927703F}, {4.364376F, 4.422847F, 4.16754F}},
    {"Cu", {0.216561F, 0.958162F, 1.165808F}, {3.637741F, 2.577065F, 2.393857F}},
    {"Ir", {2.56458F, 2.229188F, 1.827596F}, {4.671483F, 4.31366F, 3.662789F}},
    {"Li", {0.226407F, 0.206173F, 0.238218F}, {3.014958F, 2.474167F, 1.904895F}},
    {"Mo", {3.735355F, 3.776585F, 3.101995F}, {3.575355F, 3.520567F, 3.459591F}},
    {"Rh", {2.193806F, 1.96683F, 1.750693F}, {5.740644F, 5.016018F, 4.452295F}},
    {"W", {3.692451F, 3.5F, 3.308961F}, {2.93698F, 2.729147F, 2.525846F}}}};

const Metal* metal_of(const Json& extension) {
  const Json* name = member(extension, "metal");
  if (name == nullptr) return nullptr;
  const auto found = std::ranges::find(kMetals, to_string(*name), &Metal::name);
  return found == kMetals.end() ? nullptr : &*found;
}

void check_anisotropy(const JsonView& extension, std::size_t texture_count) {
  as_number(extension, "anisotropyStrength");
  as_number(extension, "anisotropyRotation");
  check_texture_slot(extension, "anisotropyTexture", texture_count);
}

void read_anisotropy(const JsonView& extension, const Factors& factors, Material& material) {
  material.anisotropy = factors.unit(&extension.value, "anisotropyStrength", 0.0);
  // The angle is brought within a turn in double, because floats of many turns are coarse.
  material.anisotropy_rotation_rad =
      std::remainder(number_of(&extension.value, "anisotropyRotation", 0.0), 2 * std::numbers::pi);
}

void find_anisotropy_texture(const JsonView& extension, TextureReader& textures, Material& material) {
  if (material.anisotropy > 0) material.anisotropy_texture = textures.find(extension, "anisotropyTexture", false);
}

void check_phong(const JsonView& extension, std::size_t) {
  as_number(extension, "shininess");
  has_numbers(extension, "specular", 3);
}

void read_phong(const JsonView& extension, const Factors& factors, Material& material) {
  material.lobe = Lobe::phong;
  material.phong_shininess =
      factors.clamped(number_of(&extension.value, "shininess", 32.0), "shininess", 0.0, kMaxShininess);
  material.phong_specular = factors.color(&extension.value, "specular", 0.04);
  material.metallic = material.transmission = material.diffuse_transmission = 0.0F;
}

void check_conductor(const JsonView& extension, std::size_t) {
  const std::string* const name = as_string(extension, "metal");
  const bool has_eta = has_numbers(extension, "eta", 3), has_k = has_numbers(extension, "k", 3);
  if (name == nullptr) {
    if (!has_eta || !has_k)
      extension.refuse(R"(needs "eta" and "k", three numbers each, or "metal", a chemical symbol)");
    return;
  }
  if (has_eta || has_k) extension.refuse(R"(has both "metal" and an index of its own; leave one out)");
  if (metal_of(extension.value) != nullptr) return;
  std::string known;
  for (const Metal& metal : kMetals) known += (known.empty() ? "" : ", ") + std::string(metal.name);
  extension.refuse(fmt::format("metal {} is not known; use one of {}, or \"eta\" and \"k\"", in_quotes(*name), known));
}

void read_conductor(const JsonView& extension, const Factors& factors, Material& material) {
  const auto index = [&](const char* key) {
    glm::vec3 rgb(0.0F);
    const Json& values = *member(extension.value, key);
    for (int c = 0; c < 3; ++c)
      rgb[c] = factors.clamped(number_at(values, static_cast<std::size_t>(c)), key, 0.0, kMaxIndex);
    return rgb;
  };
  const Metal* const metal = metal_of(extension.value);
  material.conductor_eta = metal != nullptr ? metal->eta : index("eta");
  material.conductor_k = metal != nullptr ? metal->k : index("k");
  if (material.lobe)
    factors.material().refuse("it has EIKON_materials_phong and EIKON_materials_conductor; leave one out");
  material.lobe = Lobe::conductor;
  material.metallic = 1.0F;
  material.transmission = material.diffuse_transmission = 0.0F;
}

constexpr MaterialExtensionReader kMicrofacetsExtensions[] = {
    {.name = "KHR_materials_anisotropy",
     .check = check_anisotropy,
     .read = read_anisotropy,
     .find_textures = find_anisotropy_texture},
    {.name = "EIKON_materials_phong", .check = check_phong, .read = read_phong},
    {.name = "EIKON_materials_conductor", .check = check_conductor, .read = read_conductor},
};

}  // namespace

std::span<const MaterialExtensionReader> microfacet_extensions() { return kMicrofacetsExtensions; }

}  // namespace eikon
