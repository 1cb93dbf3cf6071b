// SPDX-License-Identifier: Apache-2.0
// Every lobe of features.def against the contract of bsdf.h. A lobe without a material here does not compile.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "shared/records.h"

namespace eikon::test {
namespace {

using Direction = std::array<float, 3>;

MaterialRecord material_with_only(unsigned bit) {
  MaterialRecord m{};
  m.flags = 1U << bit;
  m.ior = 1.5F;
  m.base_color_texture = m.metallic_roughness_texture = m.normal_texture = m.emissive_texture = EK_NO_TEXTURE;
  return m;
}

std::vector<MaterialExtension> extensions_of(const std::vector<MaterialRecord>& materials) {
  MaterialExtension plain{};
  plain.specular = plain.specular_color_r = plain.specular_color_g = plain.specular_color_b = 1;
  plain.transmission_texture = plain.specular_texture = plain.specular_color_texture = EK_NO_TEXTURE;
  return std::vector<MaterialExtension>(materials.size(), plain);
}

std::vector<MaterialRecord> materials_of_diffuse(unsigned bit) {
  MaterialRecord white = material_with_only(bit), coloured = white;
  white.base_color_r = white.base_color_g = white.base_color_b = 1;
  coloured.base_color_r = 0.8F;
  coloured.base_color_g = 0.3F;
  coloured.base_color_b = 0;
  return {white, coloured};
}

std::vector<MaterialRecord> materials_of_metallic_roughness(unsigned bit) { return materials_of_diffuse(bit); }
std::vector<MaterialRecord> materials_of_transmission(unsigned bit) { return materials_of_diffuse(bit); }

struct Lobe {
  const char* name;
  std::vector<MaterialRecord> materials;
  bool lossless;  // the first material scatters all light
};
const std::vector<Lobe>& lobes() {
  static const std::vector<Lobe> all{
#define EK_LOBE(name, bit) {#name, materials_of_##name(bit), true},
#include "shared/features.def"
  };
  return all;
}

Direction from_angle(double theta_deg, double turn) {
  const double theta = theta_deg * std::numbers::pi / 180, phi = turn * 2 * std::numbers::pi;
  return {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)), float(std::cos(theta))};
}
Direction from_cosine(double z, double turn) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z)), phi = turn * 2 * std::numbers::pi;
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)};
}

struct Queries {
  std::vector<Words> in = std::vector<Words>(10);
  void add(std::uint32_t material, const Direction& wo, const Direction& wi, float u, float v, float choice) {
    in[0].push_back(material);
    for (std::size_t k = 0; k < 3; ++k) {
      in[1 + k].push_back(as_word(wo[k]));
      in[4 + k].push_back(as_word(wi[k]));
    }
    in[7].push_back(as_word(u));
    in[8].push_back(as_word(v));
    in[9].push_back(as_word(choice));
  }
};

/// Outputs: 0 eval, 3 pdf, 4 sampled weight, 7 wi, 10 pdf, 11 eval of it, 14 pdf of it, 15 emission, 18 double sided.
std::vector<Words> scatter(const std::vector<MaterialRecord>& materials, const Queries& q, bool uniform) {
  return Probe("bsdf")
      .buffer("materials", materials)
      .buffer("triangles", std::vector<Triangle>(1))
      .buffer("triangle_normals", std::vector<TriangleNormals>(1))
      .buffer("triangle_tangents", std::vector<TriangleTangents>(1))
      .buffer("triangle_colors", std::vector<TriangleColors>{{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0}})
      .buffer("material_extensions", extensions_of(materials))
      .buffer("textures", std::vector<TextureRecord>(1))
      .buffer("texels", std::vector<std::uint32_t>(EK_TEXEL_TABLE + 1))
      .define("EK_HAS_uniform_scatter", uniform ? "1" : "0")
      .run("probe_bsdf", q.in, 19);
}

float uniform(std::mt19937& random) { return float(random() >> 8) * 0x1p-24F; }

constexpr double kAngles[] = {0, 45, 85, 89.9};

TEST(Bsdf, M1_samples_have_the_density_that_pdf_states) {
  constexpr unsigned kSamples = 400000, kRows = 20, kColumns = 41, kPoints = 8;
  const double alpha = sidak(lobes().size() * std::size(kAngles) * 2);
  std::mt19937 random(1);
  for (const Lobe& lobe : lobes())
    for (const bool uniform_scatter : {false, true})
      for (const double angle : kAngles) {
        const Direction wo = from_angle(angle, 0.1);
        Queries q;
        for (unsigned i = 0; i < kSamples; ++i)
          q.add(0, wo, {0, 0, 1}, uniform(random), uniform(random), uniform(random));
        const auto sampled = scatter(lobe.materials, q, uniform_scatter);
        Queries grid;
        for (unsigned row = 0; row < 2 * kRows * kPoints; ++row)
          for (unsigned column = 0; column < kColumns * kPoints; ++column)
            grid.add(0, wo, from_cosine((row + 0.5) / (kRows * kPoints) - 1, (column + 0.5) / (kColumns * kPoints)), 0,
                     0, 0);
        const auto stated = scatter(lobe.materials, grid, uniform_scatter);
        std::vector<double> observed(2 * kRows * kColumns, 0), expected(2 * kRows * kColumns, 0);
        const double solid_angle = 4 * std::numbers::pi / double(grid.in[0].size());
        double total = 0;
        for (std::size_t i = 0; i < grid.in[0].size(); ++i) {
          const std::size_t row = i / (kColumns * kPoints) / kPoints, column = i % (kColumns * kPoints) / kPoints;
          const double share = double(as_float(stated[3][i])) * solid_angle;
          expected[row * kColumns + column] += share * kSamples;
          total += share;
        }
        EXPECT_NEAR(total, 1, 1e-4) << lobe.name << " at " << angle << " degrees";
        for (unsigned i = 0; i < kSamples; ++i) {
          if (as_float(sampled[10][i]) == 0) continue;
          const double x = as_float(sampled[7][i]), y = as_float(sampled[8][i]), z = as_float(sampled[9][i]);
          double turn = std::atan2(y, x) / (2 * std::numbers::pi);
          if (turn < 0) turn += 1;
          ++observed[std::min(unsigned((z + 1) * kRows), 2 * kRows - 1) * kColumns +
                     std::min(unsigned(turn * kColumns), kColumns - 1)];
        }
        const ChiSquare test = chi_square(observed, expected);
        EXPECT_GT(test.p_value, alpha) << lobe.name << " at " << angle << " degrees"
                                       << (uniform_scatter ? ", uniform" : "") << '\n'
                                       << test.table;
      }
}

TEST(Bsdf, weight_is_eval_over_pdf_and_pdf_is_that_of_the_sampled_direction) {
  std::mt19937 random(2);
  for (const Lobe& lobe : lobes())
    for (const bool uniform_scatter : {false, true}) {
      Queries q;
      for (int i = 0; i < 1 << 16; ++i)
        q.add(std::uint32_t(i) % std::uint32_t(lobe.materials.size()), from_cosine(uniform(random), uniform(random)),
              {0, 0, 1}, uniform(random), uniform(random), uniform(random));
      const auto out = scatter(lobe.materials, q, uniform_scatter);
      for (std::size_t i = 0; i < q.in[0].size(); ++i) {
        const double pdf = as_float(out[10][i]);
        ASSERT_NEAR(as_float(out[14][i]), pdf, 1e-6 * pdf) << lobe.name << ", " << i;
        if (pdf == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          const double eval = as_float(out[11 + c][i]);
          ASSERT_NEAR(double(as_float(out[4 + c][i])) * pdf, eval, 1e-5 * eval) << lobe.name << ", " << i;
        }
      }
    }
}

TEST(Bsdf, M2_light_paths_can_be_reversed) {
  std::mt19937 random(3);
  for (const Lobe& lobe : lobes()) {
    Queries forward, backward;
    for (int i = 0; i < 100000; ++i) {
      const Direction wo = from_cosine(uniform(random), uniform(random)),
                      wi = from_cosine(uniform(random), uniform(random));
      const auto material = std::uint32_t(i) % std::uint32_t(lobe.materials.size());
      forward.add(material, wo, wi, 0, 0, 0);
      backward.add(material, wi, wo, 0, 0, 0);
    }
    const auto there = scatter(lobe.materials, forward, false), back = scatter(lobe.materials, backward, false);
    for (std::size_t i = 0; i < forward.in[0].size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double f = double(as_float(there[c][i])) * as_float(forward.in[3][i]);  // eval holds the cosine of wi
        const double g = double(as_float(back[c][i])) * as_float(forward.in[6][i]);
        ASSERT_NEAR(f, g, 1e-5 * std::max(f, g)) << lobe.name << ", pair " << i;
      }
  }
}

TEST(Bsdf, M5_no_more_light_leaves_than_arrives_and_none_is_lost_in_the_white_furnace) {
  std::mt19937 random(4);
  for (const Lobe& lobe : lobes())
    for (const bool uniform_scatter : {false, true})
      for (const double angle : kAngles) {
        Queries q;
        for (int i = 0; i < 200000; ++i)
          q.add(0, from_angle(angle, 0.7), {0, 0, 1}, uniform(random), uniform(random), uniform(random));
        const auto out = scatter(lobe.materials, q, uniform_scatter);
        std::vector<double> weights;
        for (std::size_t i = 0; i < q.in[0].size(); ++i)
          weights.push_back(as_float(out[10][i]) > 0 ? as_float(out[4][i]) : 0.0F);
        const Mean albedo = mean_of(weights);
        const double tolerance = 4 * albedo.standard_error + 1e-6;
        EXPECT_LE(albedo.mean, 1 + tolerance) << lobe.name << " at " << angle;
        EXPECT_GE(albedo.mean, lobe.lossless ? 1 - tolerance : 0) << lobe.name << " at " << angle;
      }
}

TEST(Bsdf, lambert_returns_its_base_color_from_every_sample) {
  std::mt19937 random(5);
  const auto materials = materials_of_diffuse(0);
  Queries q;
  for (int i = 0; i < 4096; ++i)
    q.add(1, from_cosine(uniform(random) + 1e-3F, 0), {0, 0, 1}, uniform(random), uniform(random), 0);
  const auto out = scatter(materials, q, false);
  for (std::size_t i = 0; i < q.in[0].size(); ++i) {
    ASSERT_EQ(as_float(out[4][i]), materials[1].base_color_r);
    ASSERT_EQ(as_float(out[5][i]), materials[1].base_color_g);
    ASSERT_EQ(as_float(out[6][i]), materials[1].base_color_b);
  }
}

TEST(Bsdf, scattering_is_linear_in_the_albedo) {
  std::mt19937 random(6);
  auto materials = materials_of_diffuse(0);
  materials.push_back(materials[1]);
  materials[2].base_color_r *= 0.25F;
  materials[2].base_color_g *= 0.25F;
  Queries full, quarter;
  for (int i = 0; i < 4096; ++i) {
    const Direction wo = from_cosine(uniform(random), 0.2), wi = from_cosine(uniform(random), 0.9);
    full.add(1, wo, wi, 0.3F, 0.4F, 0);
    quarter.add(2, wo, wi, 0.3F, 0.4F, 0);
  }
  const auto a = scatter(materials, full, false), b = scatter(materials, quarter, false);
  for (std::size_t i = 0; i < full.in[0].size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(as_float(b[c][i]), 0.25F * as_float(a[c][i]));
}

TEST(Bsdf, M19_directions_in_or_below_the_surface_scatter_nothing_and_stay_finite) {
  for (const Lobe& lobe : lobes())
    for (const bool uniform_scatter : {false, true}) {
      Queries q;
      const float heights[] = {0, -0.0F, 1e-8F, -1e-8F, 1e-30F, -1, 1, 0.5F};
      for (const float wo_z : heights)
        for (const float wi_z : heights)
          q.add(0, {std::sqrt(1 - wo_z * wo_z), 0, wo_z}, {0, std::sqrt(1 - wi_z * wi_z), wi_z}, 0.4F, 0.6F, 0.5F);
      const auto out = scatter(lobe.materials, q, uniform_scatter);
      for (std::size_t i = 0; i < q.in[0].size(); ++i) {
        const float wo_z = as_float(q.in[3][i]), wi_z = as_float(q.in[6][i]);
        for (std::size_t k = 0; k < 15; ++k)
          ASSERT_TRUE(std::isfinite(as_float(out[k][i]))) << lobe.name << ", output " << k;
        for (std::size_t k = 0; k < 4; ++k)
          if (wo_z <= 0 || wi_z <= 0) {
            ASSERT_EQ(as_float(out[k][i]), 0) << lobe.name << ", wo.z " << wo_z << ", wi.z " << wi_z;
          } else {
            ASSERT_GT(as_float(out[k][i]), 0) << lobe.name << ", wo.z " << wo_z << ", wi.z " << wi_z;
          }
        ASSERT_EQ(as_float(out[10][i]) > 0, wo_z > 0) << lobe.name << ", wo.z " << wo_z;
      }
    }
}

TEST(Bsdf, N2_the_ends_of_the_unit_interval_are_samples_like_any_other) {
  for (const Lobe& lobe : lobes()) {
    Queries q;
    for (const float u : {0.0F, 1 - 0x1p-24F})
      for (const float v : {0.0F, 1 - 0x1p-24F})
        for (const float choice : {0.0F, 1 - 0x1p-24F}) q.add(0, from_angle(30, 0), {0, 0, 1}, u, v, choice);
    const auto out = scatter(lobe.materials, q, false);
    for (std::size_t i = 0; i < q.in[0].size(); ++i) {
      EXPECT_GT(as_float(out[10][i]), 0) << lobe.name << ", " << i;
      for (std::size_t k = 4; k < 11; ++k) EXPECT_TRUE(std::isfinite(as_float(out[k][i]))) << lobe.name << ", " << i;
    }
  }
}

TEST(Bsdf, a_material_without_lobes_is_black_and_still_emits) {
  MaterialRecord lamp{};
  lamp.emission_r = 17;
  lamp.emission_g = 12;
  lamp.emission_b = 4;
  lamp.flags = EK_MATERIAL_DOUBLE_SIDED;
  lamp.base_color_texture = lamp.metallic_roughness_texture = lamp.emissive_texture = EK_NO_TEXTURE;
  Queries q;
  q.add(0, from_angle(20, 0), from_angle(50, 0.5), 0.2F, 0.9F, 0.5F);
  const auto out = scatter({lamp}, q, false);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(as_float(out[k][0]), 0);
  EXPECT_EQ(as_float(out[10][0]), 0) << "nothing may be sampled";
  EXPECT_EQ(as_float(out[15][0]), 17);
  EXPECT_EQ(as_float(out[16][0]), 12);
  EXPECT_EQ(as_float(out[17][0]), 4);
  EXPECT_EQ(out[18][0], 1U);
}

}  // namespace
}  // namespace eikon::test
