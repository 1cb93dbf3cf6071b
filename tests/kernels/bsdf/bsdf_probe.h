// SPDX-License-Identifier: Apache-2.0
// Materials, directions and the probe that the tests of BSDF lobes share.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "shared/records.h"

namespace eikon::test {

enum : unsigned {
#define EK_LOBE(name, bit, traits) kLobe_##name = bit,
#include "shared/features.def"
};

using Direction = std::array<float, 3>;

inline Direction from_angle(double theta_deg, double turn) {
  const double theta = theta_deg * std::numbers::pi / 180, phi = turn * 2 * std::numbers::pi;
  return {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)), float(std::cos(theta))};
}
inline Direction from_cosine(double z, double turn) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z)), phi = turn * 2 * std::numbers::pi;
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)};
}

/// The parameters of a material as a file gives them; the probe makes the records of
/// kernels/shared/records.def from them.
struct ProbeMaterial {
  std::array<float, 3> base_color = {1, 1, 1};
  float metallic = 0, roughness = 1, ior = 1.5F;
  float specular = 1;
  std::array<float, 3> specular_color = {1, 1, 1};
  float transmission = 0;
  bool solid = false;
  float clearcoat = 0, clearcoat_roughness = 0;
  Direction clearcoat_normal = {0, 0, 1}, geometric_normal = {0, 0, 1};
  std::array<float, 3> sheen = {0, 0, 0};
  float sheen_roughness = 0;
  float roughness_x = -1;  // of anisotropic ones
  float shininess = 0;
  std::array<float, 3> highlight = {0, 0, 0};
  float diffuse_transmission = 0;
  std::array<float, 3> diffuse_transmission_color = {1, 1, 1};
  std::array<float, 3> eta = {1, 1, 1}, k = {0, 0, 0};
  float iridescence = 0, thin_film_index = 1.3F, thin_film_nm = 0;
};

/// A material of one lobe, of which a surface is hit.
struct Specimen {
  std::string name;
  unsigned lobe = 0;  // bit of features.def
  ProbeMaterial material;
  bool front = true;
  bool reciprocal = true;  // KHR_materials_clearcoat's mixing is not
  bool lets_through() const { return material.transmission > 0 || material.diffuse_transmission > 0; }
  /// The coat may reflect to directions below the horizon of what it lies on.
  bool has_leaning_base() const { return material.geometric_normal[2] != 1; }
  bool refracts() const { return material.solid && material.transmission > 0; }
  double eta() const { return front ? material.ior : 1 / double(material.ior); }
  /// The least roughness of what scatters.
  float narrowest() const;
};

/// Specimens of every lobe at this roughness, a solid's back included. A lobe without any does not
/// compile.
std::vector<Specimen> specimens(float roughness);

/// What is asked about specimens: sampling at (u, v, choice), and eval and pdf of wi.
struct Queries {
  std::vector<Words> in = std::vector<Words>(18);
  std::size_t compared = 8192;  // so many, evenly among all, on every device and lane width
  void add(std::uint32_t specimen, const Direction& wo, const Direction& wi, float u, float v, float choice);
  void add(std::uint32_t specimen, const Direction& wo, std::mt19937& random);
  /// So many samples.
  void draw(std::size_t count, std::uint32_t specimen, const Direction& wo, std::mt19937& random);
  std::size_t size() const { return in[0].size(); }
};

struct Sampled {
  std::array<double, 3> weight, wi, eval;  // eval of wi
  double pdf, pdf_again;                   // as sample says, and as pdf says of wi
  bool delta;
};
struct Answers {
  std::vector<Words> out;
  double eval(std::size_t i, std::size_t channel) const { return as_float(out[channel][i]); }
  double pdf(std::size_t i) const { return as_float(out[3][i]); }
  Sampled sample(std::size_t i) const;
};

/// uniform: with EK_HAS_uniform_scatter; anisotropic: with EK_HAS_anisotropy; compensated: with
/// EK_HAS_energy_compensation
Answers scatter(const std::vector<Specimen>& specimens, const Queries& q, bool uniform = false, bool anisotropic = true,
                bool compensated = false);

/// The same of records; all fronts. texels: of textures and measured tables, or empty
std::vector<Words> scatter(const std::vector<MaterialRecord>& materials,
                           const std::vector<MaterialExtension>& extensions, const std::vector<MaterialDetail>& details,
                           const Queries& q, bool uniform, bool anisotropic = true, const Words& texels = {},
                           bool compensated = false, const std::vector<std::string>& without = {});

/// Of the kernels that ask about thin films alone: a program of little else, which compiles in a
/// tenth of the time.
Probe thin_film_probe();

}  // namespace eikon::test
