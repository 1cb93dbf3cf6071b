// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_microfacets.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace eikon {
namespace {

constexpr double kMaxShininess = 1e4;  // floats resolve no narrower highlights
constexpr double kMaxIndex = 0x1p14;   // its fourth power stays finite in the kernels

// Indices of refraction at 650, 550 and 450 nm, which stand for R, G and B: the middles of what the three primaries see. One
// wavelength each, so that the reflectance is a metal's own there; a mean over each primary's band would be of no wavelength.
// source  luxpop.com's tables (Palik, Handbook of Optical Constants of Solids; Johnson and Christy 1972), interpolated linearly
struct Metal {
  std::string_view name;
  Conductor index;
};
constexpr std::array<Metal, 10> kMetals{{{"Ag", {{0.13941F, 0.124777F, 0.151691F}, {4.128773F, 3.3396F, 2.47042F}}},
                                         {"Al", {{1.47477F, 0.958569F, 0.617953F}, {7.794109F, 6.686968F, 5.469423F}}},
                                         {"Au", {{0.16779F, 0.350409F, 1.508458F}, {3.137816F, 2.714063F, 1.87885F}}},
                                         {"Cr", {{3.637546F, 3.115763F, 1.927703F}, {4.364376F, 4.422847F, 4.16754F}}},
                                         {"Cu", {{0.216561F, 0.958162F, 1.165808F}, {3.637741F, 2.577065F, 2.393857F}}},
                                         {"Ir", {{2.56458F, 2.229188F, 1.827596F}, {4.671483F, 4.31366F, 3.662789F}}},
                                         {"Li", {{0.226407F, 0.206173F, 0.238218F}, {3.014958F, 2.474167F, 1.904895F}}},
                                         {"Mo", {{3.735355F, 3.776585F, 3.101995F}, {3.575355F, 3.520567F, 3.459591F}}},
                                         {"Rh", {{2.193806F, 1.96683F, 1.750693F}, {5.740644F, 5.016018F, 4.452295F}}},
                                         {"W", {{3.692451F, 3.5F, 3.308961F}, {2.93698F, 2.729147F, 2.525846F}}}}};

const Metal* metal_of(const Json& extension) {
  const Json* name = member(extension, "metal");
  if (name == nullptr) return nullptr;
  const auto found = std::ranges::find(kMetals, name->get_ref<const std::string&>(), &Metal::name);
  return found == kMetals.end() ? nullptr : &*found;
}

void check_conductor(const Place& extension) {
  check_string(extension, "metal");
  const bool has_eta = has_numbers(extension, "eta", 3), has_k = has_numbers(extension, "k", 3);
  const Json* name = member(extension.value, "metal");
  if (name == nullptr) {
    if (!has_eta || !has_k)
      extension.refuse(R"(needs "eta" and "k", three numbers each, or "metal", a chemical symbol)");
    return;
  }
  if (has_eta || has_k) extension.refuse(R"(has both "metal" and an index of its own; leave one out)");
  if (metal_of(extension.value) != nullptr) return;
  std::string known;
  for (const Metal& metal : kMetals) known += (known.empty() ? "" : ", ") + std::string(metal.name);
  extension.refuse(fmt::format("metal {} is not known; use one of {}, or \"eta\" and \"k\"",
                               in_quotes(name->get_ref<const std::string&>()), known));
}

}  // namespace

bool check_microfacets(const Place& extension, std::size_t texture_count) {
  if (extension.kind == kAnisotropyExtension) {
    as_number(extension, "anisotropyStrength");
    as_number(extension, "anisotropyRotation");
    check_texture_slot(extension, "anisotropyTexture", texture_count);
    return true;
  }
  if (extension.kind == kPhongExtension) {
    as_number(extension, "shininess");
    has_numbers(extension, "specular", 3);
    return true;
  }
  if (extension.kind != kConductorExtension) return false;
  check_conductor(extension);
  return true;
}

void read_microfacets(const Place& place, const Factors& factors, Material& material) {
  const Json* anisotropy = extension_of(place, kAnisotropyExtension);
  material.anisotropy = factors.unit(anisotropy, "anisotropyStrength", 0.0);
  // The angle within a turn first: floats of many turns are coarse.
  material.anisotropy_rotation_rad =
      std::remainder(number_of(anisotropy, "anisotropyRotation", 0.0), 2 * std::numbers::pi);
  if (const Json* phong = extension_of(place, kPhongExtension)) {
    const Phong usual;
    material.phong = Phong{.shininess = factors.clamped(number_of(phong, "shininess", double(usual.shininess)),
                                                        "shininess", 0.0, kMaxShininess),
                           .specular = factors.colour(phong, "specular", double(usual.specular.x))};
  }
  const Json* conductor = extension_of(place, kConductorExtension);
  if (conductor == nullptr) return;
  if (const Metal* metal = metal_of(*conductor)) {
    material.conductor = metal->index;
    return;
  }
  const auto index = [&](const char* key) {
    glm::vec3 rgb(0.0F);
    const Json& values = *member(*conductor, key);
    for (int c = 0; c < 3; ++c)
      rgb[c] = factors.clamped(values[static_cast<std::size_t>(c)].get<double>(), key, 0.0, kMaxIndex);
    return rgb;
  };
  material.conductor = Conductor{.eta = index("eta"), .k = index("k")};
}

void complete_microfacets(const Place& place, TextureReader& textures, Material& material) {
  const Json* anisotropy = extension_of(place, kAnisotropyExtension);
  if (anisotropy == nullptr || !(material.anisotropy > 0)) return;
  material.anisotropy_texture =
      textures.find({.value = *anisotropy, .kind = kAnisotropyExtension, .parent = &place}, "anisotropyTexture", false);
}

}  // namespace eikon
