// SPDX-License-Identifier: Apache-2.0
#include "kernels/bsdf/bsdf_probe.h"

namespace eikon::test {
namespace {

std::vector<Specimen> diffuse_specimens(unsigned lobe, float) {
  return {{"white Lambert", lobe, {}}, {"coloured Lambert", lobe, {.base_color = {0.8F, 0.3F, 0}}}};
}

std::vector<Specimen> metallic_roughness_specimens(unsigned lobe, float roughness) {
  const ProbeMaterial plastic{.base_color = {0.8F, 0.5F, 0.2F}, .roughness = roughness};
  ProbeMaterial white = plastic, coated = plastic, half = plastic, metal = plastic;
  white.base_color = {1, 1, 1};
  coated.ior = 1.8F;
  coated.specular = 0.7F;
  coated.specular_color = {1, 0.5F, 0};
  half.metallic = 0.5F;
  metal.metallic = 1;
  return {{"white plastic", lobe, white},
          {"plastic", lobe, plastic},
          {"plastic of coloured specular", lobe, coated},
          {"half metal", lobe, half},
          {"metal", lobe, metal}};
}

std::vector<Specimen> transmission_specimens(unsigned lobe, float roughness) {
  const ProbeMaterial clear{.roughness = roughness, .transmission = 1};
  ProbeMaterial pane = clear, mixed = clear, glass = clear, tinted = clear, water = clear, dim = clear;
  pane.base_color = {0.9F, 0.5F, 0.1F};
  pane.specular = 0.5F;
  mixed.base_color = {0.7F, 0.6F, 0.3F};
  mixed.metallic = 0.2F;
  mixed.transmission = 0.6F;
  glass.solid = true;
  tinted = mixed;
  tinted.solid = true;
  water.solid = true;
  water.ior = 1.33F;
  water.base_color = {0.4F, 0.7F, 0.9F};
  dim.solid = true;
  dim.specular = 0.6F;
  dim.specular_color = {3, 0.5F, 0};
  ProbeMaterial paper{.roughness = roughness, .diffuse_transmission = 0.5F};
  ProbeMaterial leaf = paper, wax = paper, frosted = paper;
  leaf.base_color = {0.2F, 0.6F, 0.1F};
  leaf.diffuse_transmission = 0.8F;
  leaf.diffuse_transmission_color = {0.7F, 0.9F, 0};
  wax.solid = true;
  wax.diffuse_transmission = 1;
  frosted.transmission = 0.4F;
  frosted.metallic = 0.1F;
  return {{"paper", lobe, paper},
          {"leaf", lobe, leaf},
          {"wax", lobe, wax},
          {"wax, from inside", lobe, wax, false},
          {"frosted pane", lobe, frosted},
          {"clear pane", lobe, clear},
          {"tinted pane", lobe, pane},
          {"half transparent pane", lobe, mixed},
          {"glass", lobe, glass},
          {"glass, from inside", lobe, glass, false},
          {"half transparent solid", lobe, tinted},
          {"half transparent solid, from inside", lobe, tinted, false},
          {"water, from inside", lobe, water, false},
          {"glass of coloured specular", lobe, dim},
          {"glass of coloured specular, from inside", lobe, dim, false}};
}

std::vector<Specimen> conductor_specimens(unsigned lobe, float roughness) {
  ProbeMaterial gold{.metallic = 1, .roughness = roughness};
  gold.eta = {0.16779F, 0.350409F, 1.508458F};
  gold.k = {3.137816F, 2.714063F, 1.87885F};
  ProbeMaterial tinted = gold, brushed = gold;
  tinted.base_color = {0.9F, 0.5F, 0};
  tinted.eta = {1.5F, 0.5F, 3};
  tinted.k = {0, 0, 7};
  brushed.roughness = roughness < 1 ? roughness : 0.5F;
  brushed.roughness_x = std::min(1.0F, 1.7F * brushed.roughness);
  return {{"gold", lobe, gold}, {"tinted conductor", lobe, tinted}, {"brushed gold", lobe, brushed}};
}

/// Shininess goes with the roughness: alpha^2 = 2 / (n + 2) makes highlights as wide as GGX's.
std::vector<Specimen> phong_specimens(unsigned lobe, float roughness) {
  const double alpha2 = std::pow(double(roughness), 4);
  ProbeMaterial plastic{.base_color = {0.7F, 0.3F, 0.1F}, .roughness = std::max(roughness, 0.15F)};
  plastic.shininess = float(std::clamp(2 / std::max(alpha2, 1e-9) - 2, 0.0, 1e4));
  plastic.highlight = {0.2F, 0.3F, 0.1F};
  ProbeMaterial white = plastic, bare = plastic;
  white.base_color = {1, 1, 1};
  white.highlight = {0.5F, 0.5F, 0.5F};
  bare.highlight = {1, 1, 1};
  return {
      {"Blinn's plastic", lobe, plastic}, {"white under highlights", lobe, white}, {"highlights alone", lobe, bare}};
}

/// Tables are 17 MB: bsdf_measured_test.cpp asks of this lobe what the others are asked together.
std::vector<Specimen> measured_specimens(unsigned, float) { return {}; }

/// glTF's materials with anisotropy.
std::vector<Specimen> anisotropic_specimens(float roughness) {
#define EK_LOBE(name, bit, traits) [[maybe_unused]] constexpr unsigned name = bit;
#include "shared/features.def"
  ProbeMaterial steel{.base_color = {0.8F, 0.7F, 0.6F}, .metallic = 1, .roughness = roughness < 1 ? roughness : 0.5F};
  steel.roughness_x = std::min(1.0F, 1.7F * steel.roughness);
  ProbeMaterial hair = steel, glass = steel;
  hair.metallic = 0;
  hair.base_color = {1, 1, 1};
  glass.metallic = 0;
  glass.transmission = 1;
  glass.solid = true;
  return {{"brushed steel", metallic_roughness, steel},
          {"brushed plastic", metallic_roughness, hair},
          {"brushed glass", transmission, glass},
          {"brushed glass, from inside", transmission, glass, false}};
}

/// glTF's materials under thin films.
std::vector<Specimen> filmy_specimens(float roughness) {
#define EK_LOBE(name, bit, traits) [[maybe_unused]] constexpr unsigned name = bit;
#include "shared/features.def"
  ProbeMaterial soap{.base_color = {1, 1, 1}, .roughness = roughness};
  soap.iridescence = 1;
  soap.thin_film_nm = 380;
  ProbeMaterial steel = soap, bubble = soap, glass = soap, half = soap;
  steel.base_color = {0.6F, 0.55F, 0.5F};
  steel.metallic = 1;
  steel.thin_film_index = 2.2F;
  bubble.transmission = 1;
  glass.transmission = 1;
  glass.solid = true;
  glass.thin_film_index = 1.8F;
  half.metallic = 0.3F;
  half.transmission = 0.5F;
  half.iridescence = 0.6F;
  ProbeMaterial rust = half;
  rust.transmission = 0;
  ProbeMaterial copper = half;
  copper.base_color = {1, 0.9F, 0.8F};
  copper.metallic = 1;
  copper.transmission = 0;
  copper.thin_film_index = 1.7F;
  copper.eta = {0.216561F, 0.958162F, 1.165808F};
  copper.k = {3.637741F, 2.577065F, 2.393857F};
  return {{"white under soap", metallic_roughness, soap},
          {"tempered steel", metallic_roughness, steel},
          {"soap bubble", transmission, bubble},
          {"coated lens", transmission, glass},
          {"coated lens, from inside", transmission, glass, false},
          {"half transparent under oil", transmission, half},
          {"partly metal under oil", metallic_roughness, rust},
          {"copper under lacquer", conductor, copper}};
}

/// Materials of several lobes with layers on them.
std::vector<Specimen> layered_specimens(float roughness) {
#define EK_LOBE(name, bit, traits) [[maybe_unused]] constexpr unsigned name = bit;
#include "shared/features.def"
  const ProbeMaterial paint{.base_color = {0.6F, 0.1F, 0.05F}, .roughness = 0.5F};
  ProbeMaterial lacquer = paint, tilted = paint, leaning = paint, velvet = paint, white = paint, both = paint,
                dipped = paint;
  lacquer.clearcoat = 1;
  lacquer.clearcoat_roughness = roughness;
  tilted.clearcoat = 0.8F;
  tilted.clearcoat_roughness = 0.6F;
  tilted.clearcoat_normal = {0.36F, 0.48F, 0.8F};
  leaning = tilted;
  leaning.geometric_normal = leaning.clearcoat_normal = {0.6F, 0, 0.8F};
  leaning.sheen = {0.3F, 0.1F, 0.2F};
  leaning.sheen_roughness = 0.5F;
  velvet.sheen = {0.9F, 0.7F, 1};
  velvet.sheen_roughness = roughness;
  velvet.base_color = {0.2F, 0, 0.1F};
  white.base_color = white.sheen = {1, 1, 1};
  white.sheen_roughness = roughness;
  white.specular = 0;
  both.sheen = {0.5F, 0.2F, 0.1F};
  both.sheen_roughness = 0.4F;
  both.clearcoat = 0.5F;
  both.clearcoat_roughness = roughness;
  both.metallic = 1;
  dipped.clearcoat = 1;
  dipped.clearcoat_roughness = 0.1F;
  dipped.roughness = roughness;
  dipped.base_color = {1, 1, 1};
  dipped.transmission = 1;
  dipped.solid = true;
  return {{"lacquer", metallic_roughness, lacquer, true, false},
          {"lacquer of a normal of its own", metallic_roughness, tilted, true, false},
          {"lacquer over a normal map", metallic_roughness, leaning, true, false},
          {"velvet", metallic_roughness, velvet},
          {"white fibres on white", diffuse, white},
          {"fibres on metal under a coat", metallic_roughness, both, true, false},
          {"coated glass", transmission, dipped, true, false}};
}

MaterialRecord record_of(const Specimen& s) {
  MaterialRecord m{};
  m.flags = (1U << s.lobe) | (s.material.solid ? EK_MATERIAL_SOLID : 0U);
  m.base_color_r = s.material.base_color[0];
  m.base_color_g = s.material.base_color[1];
  m.base_color_b = s.material.base_color[2];
  m.metallic = s.material.metallic;
  m.roughness = s.material.roughness;
  m.ior = s.material.ior;
  m.opacity = 1;
  m.base_color_texture = m.metallic_roughness_texture = m.normal_texture = m.emissive_texture = EK_NO_TEXTURE;
  return m;
}

MaterialExtension extension_of(const Specimen& s) {
  MaterialExtension e{};
  e.specular = s.material.specular;
  e.specular_color_r = s.material.specular_color[0];
  e.specular_color_g = s.material.specular_color[1];
  e.specular_color_b = s.material.specular_color[2];
  e.transmission = s.material.transmission;
  e.transmission_texture = e.specular_texture = e.specular_color_texture = EK_NO_TEXTURE;
  return e;
}

MaterialDetail detail_of(const Specimen& s) {
  MaterialDetail d{};
  d.clearcoat = s.material.clearcoat;
  d.clearcoat_roughness = s.material.clearcoat_roughness;
  d.sheen_color_r = s.material.sheen[0];
  d.sheen_color_g = s.material.sheen[1];
  d.sheen_color_b = s.material.sheen[2];
  d.sheen_roughness = s.material.sheen_roughness;
  d.clearcoat_texture = d.clearcoat_roughness_texture = d.clearcoat_normal_texture = EK_NO_TEXTURE;
  d.sheen_color_texture = d.sheen_roughness_texture = d.anisotropy_texture = EK_NO_TEXTURE;
  d.anisotropy_cos = 1;
  d.diffuse_transmission = s.material.diffuse_transmission;
  d.diffuse_transmission_color_r = s.material.diffuse_transmission_color[0];
  d.diffuse_transmission_color_g = s.material.diffuse_transmission_color[1];
  d.diffuse_transmission_color_b = s.material.diffuse_transmission_color[2];
  d.diffuse_transmission_texture = d.diffuse_transmission_color_texture = EK_NO_TEXTURE;
  d.phong_shininess = s.material.shininess;
  d.phong_specular_r = s.material.highlight[0];
  d.phong_specular_g = s.material.highlight[1];
  d.phong_specular_b = s.material.highlight[2];
  d.conductor_eta_r = s.material.eta[0];
  d.conductor_eta_g = s.material.eta[1];
  d.conductor_eta_b = s.material.eta[2];
  d.iridescence = s.material.iridescence;
  d.thin_film_index = s.material.thin_film_index;
  d.thin_film_least_nm = d.thin_film_most_nm = s.material.thin_film_nm;
  d.iridescence_texture = d.thin_film_thickness_texture = EK_NO_TEXTURE;
  d.conductor_k_r = s.material.k[0];
  d.conductor_k_g = s.material.k[1];
  d.conductor_k_b = s.material.k[2];
  return d;
}

}  // namespace

float Specimen::narrowest() const {
#define EK_LOBE(name, bit, traits) [[maybe_unused]] constexpr unsigned name = bit;
#include "shared/features.def"
  return std::min(lobe == diffuse ? 1 : material.roughness, material.clearcoat > 0 ? material.clearcoat_roughness : 1);
}

std::vector<Specimen> specimens(float roughness) {
  std::vector<Specimen> all;
#define EK_LOBE(name, bit, traits) \
  for (Specimen & s : name##_specimens(bit, roughness)) all.push_back(std::move(s));
#include "shared/features.def"
  for (Specimen& s : layered_specimens(roughness)) all.push_back(std::move(s));
  for (Specimen& s : anisotropic_specimens(roughness)) all.push_back(std::move(s));
  for (Specimen& s : filmy_specimens(roughness)) all.push_back(std::move(s));
  return all;
}

Probe thin_film_probe() {
  Probe probe("bsdf");
#define EK_LOBE(name, bit, traits) probe.define("EK_HAS_" #name, "0");
#define EK_LIGHT(name, bit) probe.define("EK_HAS_" #name, "0");
#define EK_OPTION(name) probe.define("EK_HAS_" #name, "0");
#define EK_AOV(name, channels) probe.define("EK_HAS_" #name, "0");
#include "shared/features.def"
  return probe.define("EK_HAS_iridescence", "1")
      .define("EK_HAS_metallic_roughness", "1")
      .define("EK_HAS_conductor", "1");
}

void Queries::add(std::uint32_t specimen, const Direction& wo, const Direction& wi, float u, float v, float choice) {
  in[0].push_back(specimen);
  for (std::size_t k = 0; k < 3; ++k) {
    in[1 + k].push_back(as_word(wo[k]));
    in[4 + k].push_back(as_word(wi[k]));
  }
  in[7].push_back(as_word(u));
  in[8].push_back(as_word(v));
  in[9].push_back(as_word(choice));
  in[10].push_back(1);
  for (std::size_t k = 0; k < 3; ++k) in[11 + k].push_back(as_word(k == 2 ? 1.0F : 0.0F));
  in[14].push_back(as_word(-1.0F));
  for (std::size_t k = 0; k < 3; ++k) in[15 + k].push_back(as_word(k == 2 ? 1.0F : 0.0F));
}

void Queries::add(std::uint32_t specimen, const Direction& wo, std::mt19937& random) {
  const float u = uniform(random), v = uniform(random);
  add(specimen, wo, {0, 0, 1}, u, v, uniform(random));
}

void Queries::draw(std::size_t count, std::uint32_t specimen, const Direction& wo, std::mt19937& random) {
  if (count == 0) return;
  add(specimen, wo, random);
  for (Words& words : in) words.resize(words.size() + count - 1, words.back());
  for (std::size_t i = size() - count + 1; i < size(); ++i)
    for (std::size_t k = 7; k < 10; ++k) in[k][i] = as_word(uniform(random));
}

Sampled Answers::sample(std::size_t i) const {
  const auto three = [&](std::size_t k) {
    return std::array<double, 3>{as_float(out[k][i]), as_float(out[k + 1][i]), as_float(out[k + 2][i])};
  };
  return {three(4), three(7), three(11), as_float(out[10][i]), as_float(out[14][i]), out[19][i] != 0};
}

std::vector<Words> scatter(const std::vector<MaterialRecord>& materials,
                           const std::vector<MaterialExtension>& extensions, const std::vector<MaterialDetail>& details,
                           const Queries& q, bool uniform, bool anisotropic, const Words& texels, bool compensated,
                           const std::vector<std::string>& without) {
  Probe probe("bsdf");
  for (const std::string& name : without) probe.define("EK_HAS_" + name, "0");
  // Beside a table, what compiles longest is left out.
  if (!texels.empty())
    for (const char* name : {"transmission", "clearcoat", "clearcoat_normal", "sheen", "dispersion"})
      probe.define(std::string("EK_HAS_") + name, "0");
  return probe.buffer("materials", materials)
      .buffer("triangles", std::vector<Triangle>(1))
      .buffer("triangle_normals", std::vector<TriangleNormals>(1))
      .buffer("triangle_tangents", std::vector<TriangleTangents>(1))
      .buffer("triangle_colors", std::vector<TriangleColors>{{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0}})
      .buffer("material_extensions", extensions)
      .buffer("material_details", details)
      .buffer("textures", std::vector<TextureRecord>(1))
      .buffer("texels", texels.empty() ? Words(EK_TEXEL_TABLE + 1) : texels)
      .define("EK_HAS_uniform_scatter", uniform ? "1" : "0")
      .define("EK_HAS_anisotropy", anisotropic ? "1" : "0")
      .define("EK_HAS_energy_compensation", compensated ? "1" : "0")
      .compare(q.compared)
      .run("probe_bsdf", q.in, 20);
}

/// What no specimen has. A program of everything takes a minute to compile, and there are several.
static std::vector<std::string> not_needed(const std::vector<Specimen>& specimens) {
  std::vector<std::string> without = {
      "base_color_texture", "metallic_roughness_texture",   "emissive_texture",   "transmission_texture",
      "specular_texture",   "diffuse_transmission_texture", "anisotropy_texture", "clearcoat_texture",
      "sheen_texture",      "iridescence_texture",          "dispersion"};
  const auto unless = [&](const char* name, auto has) {
    if (std::none_of(specimens.begin(), specimens.end(), has)) without.emplace_back(name);
  };
#define EK_LOBE(name, bit, traits) unless(#name, [](const Specimen& s) { return s.lobe == bit; });
#include "shared/features.def"
  unless("clearcoat", [](const Specimen& s) { return s.material.clearcoat > 0; });
  unless("clearcoat_normal", [](const Specimen& s) { return s.material.clearcoat_normal[2] != 1; });
  unless("sheen", [](const Specimen& s) { return s.material.sheen != std::array<float, 3>{0, 0, 0}; });
  unless("iridescence", [](const Specimen& s) { return s.material.iridescence > 0; });
  unless("diffuse_transmission", [](const Specimen& s) { return s.material.diffuse_transmission > 0; });
  unless("solid_specular", [](const Specimen& s) {
    const bool usual = s.material.specular == 1 && s.material.specular_color == std::array<float, 3>{1, 1, 1};
    return s.refracts() && !usual;
  });
  return without;
}

Answers scatter(const std::vector<Specimen>& specimens, const Queries& q, bool uniform, bool anisotropic,
                bool compensated) {
  std::vector<MaterialRecord> materials;
  std::vector<MaterialExtension> extensions;
  std::vector<MaterialDetail> details;
  for (const Specimen& s : specimens) {
    materials.push_back(record_of(s));
    extensions.push_back(extension_of(s));
    details.push_back(detail_of(s));
  }
  Queries sided = q;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Specimen& s = specimens.at(q.in[0][i]);
    sided.in[10][i] = s.front ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      sided.in[11 + k][i] = as_word(s.material.clearcoat_normal[k]);
      sided.in[15 + k][i] = as_word(s.material.geometric_normal[k]);
    }
    sided.in[14][i] = as_word(s.material.roughness_x < 0 ? -1 : s.material.roughness_x * s.material.roughness_x);
  }
  return {scatter(materials, extensions, details, sided, uniform, anisotropic, {}, compensated, not_needed(specimens))};
}

}  // namespace eikon::test
