// SPDX-License-Identifier: Apache-2.0
// Every lobe of features.def against the contract of bsdf.h.
#include <gtest/gtest.h>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

constexpr float kRoughnesses[] = {0, 0.02F, 0.05F, 0.3F, 1};

std::uint32_t any_of(const std::vector<Specimen>& all, int i) { return std::uint32_t(i) % std::uint32_t(all.size()); }

TEST(Bsdf, weight_is_eval_over_pdf_and_pdf_is_that_of_the_sampled_direction) {
  std::mt19937 random(2);
  for (const float roughness : kRoughnesses) {
    const auto all = specimens(roughness);
    Queries q;
    for (int i = 0; i < 1 << 17; ++i) q.add(any_of(all, i), from_cosine(uniform(random), uniform(random)), random);
    const Answers answers = scatter(all, q);
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Sampled s = answers.sample(i);
      SCOPED_TRACE(all[q.in[0][i]].name + ", roughness " + std::to_string(roughness) + ", query " + std::to_string(i));
      if (s.pdf == 0) continue;
      ASSERT_NEAR(s.wi[0] * s.wi[0] + s.wi[1] * s.wi[1] + s.wi[2] * s.wi[2], 1, 1e-6);
      if (s.delta) {
        ASSERT_LE(s.pdf, 1.000001);
        continue;
      }
      ASSERT_EQ(s.pdf_again, s.pdf);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(s.weight[c] * s.pdf, s.eval[c], 1e-6 * s.eval[c] + 1e-30);
    }
  }
}

TEST(Bsdf, delta_samples_go_exactly_where_mirrors_and_interfaces_send_them) {
  std::mt19937 random(7);
  const auto all = specimens(0);
  Queries q;
  for (int i = 0; i < 1 << 16; ++i) q.add(any_of(all, i), from_cosine(uniform(random), uniform(random)), random);
  const Answers answers = scatter(all, q);
  std::size_t mirrored = 0, straight = 0, refracted = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    if (!s.delta) continue;
    const Specimen& specimen = all[q.in[0][i]];
    const double x = as_float(q.in[1][i]), y = as_float(q.in[2][i]), z = as_float(q.in[3][i]);
    SCOPED_TRACE(specimen.name);
    if (s.wi[2] > 0) {
      ++mirrored;
      ASSERT_EQ(s.wi, (std::array<double, 3>{-x, -y, z}));
    } else if (!specimen.material.solid) {
      ++straight;
      ASSERT_EQ(s.wi, (std::array<double, 3>{-x, -y, -z}));
    } else {
      ++refracted;
      ASSERT_NEAR(s.wi[0] * specimen.eta(), -x, 3e-7);
      ASSERT_NEAR(s.wi[1] * specimen.eta(), -y, 3e-7);
    }
  }
  EXPECT_GT(mirrored, 1000U);
  EXPECT_GT(straight, 1000U);
  EXPECT_GT(refracted, 1000U);
}

void check_reversal(bool compensated) {
  std::mt19937 random(3);
  double worst_reflected = 0, worst_transmitted = 0;
  for (const float roughness : kRoughnesses) {
    auto all = specimens(roughness);
    const auto count = std::uint32_t(all.size());
    for (std::uint32_t i = 0; i < count; ++i) {  // the same surfaces hit from their other sides
      all.push_back(all[i]);
      all.back().front = !all[i].front;
    }
    Queries forward, backward;
    for (int i = 0; i < 100000; ++i) {
      const auto which = std::uint32_t(i) % count;
      if (!all[which].reciprocal) continue;
      const bool through = uniform(random) < 0.5F;
      const Direction wo = from_cosine(1 - uniform(random), uniform(random));
      Direction wi = from_cosine(1 - uniform(random), uniform(random));
      if (through && all[which].lets_through()) {  // seen from the other side, in its frame
        Direction back_wo = wi, back_wi = wo;
        wi[2] = -wi[2];
        back_wi[2] = -back_wi[2];
        forward.add(which, wo, wi, 0, 0, 0);
        backward.add(which + count, back_wo, back_wi, 0, 0, 0);
      } else {
        forward.add(which, wo, wi, 0, 0, 0);
        backward.add(which, wi, wo, 0, 0, 0);
      }
    }
    const Answers there = scatter(all, forward, false, true, compensated),
                  back = scatter(all, backward, false, true, compensated);
    for (std::size_t i = 0; i < forward.size(); ++i) {
      const Specimen& specimen = all[forward.in[0][i]];
      const double cos_o = as_float(forward.in[3][i]), cos_i = as_float(forward.in[6][i]);
      const bool bends = cos_i < 0 && specimen.refracts();
      const double scale = bends ? specimen.eta() * specimen.eta() : 1;  // f eta^2 is what can be reversed
      for (std::size_t c = 0; c < 3; ++c) {
        const double f = there.eval(i, c) * cos_o * scale, g = back.eval(i, c) * std::abs(cos_i);
        const double larger = std::max(f, g), difference = std::abs(f - g) / larger;
        // What passes next to the critical angle is next to nothing, and a rounded difference of
        // nearly equal numbers.
        if (larger < (bends ? 1e-4 : 1e-20)) continue;
        double& worst = bends ? worst_transmitted : worst_reflected;
        worst = std::max(worst, difference);
        ASSERT_LT(difference, bends ? 5e-3 : 1e-4)
            << specimen.name << ", roughness " << roughness << ", pair " << i << ": " << f << " and " << g;
      }
    }
  }
  ::testing::Test::RecordProperty("worst_reflected", std::to_string(worst_reflected));
  ::testing::Test::RecordProperty("worst_transmitted", std::to_string(worst_transmitted));
  std::printf("reciprocity: reflected within %.2g, refracted within %.2g\n", worst_reflected, worst_transmitted);
}

TEST(Bsdf, M2_light_paths_can_be_reversed) { check_reversal(false); }
TEST(Bsdf, M2_light_paths_with_energy_compensation_can_be_reversed) { check_reversal(true); }

TEST(Bsdf, M5_no_more_light_leaves_than_arrives) {
  constexpr int kSamples = 50000;
  std::mt19937 random(4);
  double most = 0;
  for (const float roughness : {0.0F, 0.05F, 0.3F, 0.6F, 1.0F}) {
    const auto all = specimens(roughness);
    for (std::uint32_t which = 0; which < all.size(); ++which)
      for (const double angle : {0.0, 45.0, 80.0, 89.9, 90.0}) {
        Queries q;
        q.compared = 1024;
        q.draw(kSamples, which, from_angle(angle, 0.7), random);
        const Answers answers = scatter(all, q);
        const double eta2 = all[which].refracts() ? all[which].eta() * all[which].eta() : 1;
        std::array<std::vector<double>, 3> power;  // radiance changes by eta^2 across an interface, power does not
        for (std::size_t i = 0; i < q.size(); ++i) {
          const Sampled s = answers.sample(i);
          for (std::size_t c = 0; c < 3; ++c) {
            power[c].push_back(s.pdf > 0 ? s.weight[c] * (s.wi[2] < 0 ? eta2 : 1) : 0);
            ASSERT_TRUE(std::isfinite(power[c].back()) && power[c].back() >= 0) << all[which].name;
          }
        }
        for (const auto& values : power) {
          const Mean albedo = mean_of(values);
          most = std::max(most, albedo.mean);
          EXPECT_LE(albedo.mean, 1 + 4 * albedo.standard_error + 2e-6)
              << all[which].name << ", roughness " << roughness << ", " << angle << " degrees";
        }
      }
  }
  std::printf("greatest albedo: %.6f\n", most);
}

TEST(Bsdf, M5_lambert_loses_nothing_in_the_white_furnace) {
  std::mt19937 random(4);
  const auto all = specimens(1);
  for (const bool uniform_scatter : {false, true})
    for (const double angle : {0.0, 45.0, 85.0, 89.9}) {
      Queries q;
      q.draw(200000, 0, from_angle(angle, 0.7), random);
      const Answers answers = scatter(all, q, uniform_scatter);
      std::vector<double> weights;
      for (std::size_t i = 0; i < q.size(); ++i) weights.push_back(answers.sample(i).weight[0]);
      const Mean albedo = mean_of(weights);
      EXPECT_NEAR(albedo.mean, 1, 4 * albedo.standard_error + 1e-6);
    }
}

TEST(Bsdf, lambert_returns_its_base_color_from_every_sample_and_is_linear_in_it) {
  std::mt19937 random(5);
  auto all = specimens(1);
  all[0].material.base_color = {0.25F * all[1].material.base_color[0], 0.25F * all[1].material.base_color[1], 0};
  Queries q;
  for (int i = 0; i < 4096; ++i) {
    const Direction wo = from_cosine(uniform(random) + 1e-3F, 0), wi = from_cosine(uniform(random), 0.9);
    q.add(0, wo, wi, 0.3F, 0.4F, 0);
    q.add(1, wo, wi, 0.3F, 0.4F, 0);
  }
  const Answers answers = scatter(all, q);
  for (std::size_t i = 0; i < q.size(); i += 2)
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(answers.sample(i + 1).weight[c], all[1].material.base_color[c]);
      ASSERT_EQ(answers.eval(i, c), 0.25F * answers.eval(i + 1, c));
    }
}

TEST(Bsdf, M19_directions_in_or_below_the_surface_scatter_nothing_and_stay_finite) {
  for (const float roughness : {0.0F, 0.01106F, 0.05F, 0.3F, 1.0F}) {
    const auto all = specimens(roughness);
    for (const bool uniform_scatter : {false, true}) {
      Queries q;
      const float heights[] = {0, -0.0F, 1e-8F, -1e-8F, 1e-30F, -1e-30F, -1, 1, 0.5F, -0.5F};
      for (std::uint32_t which = 0; which < all.size(); ++which)
        for (const float wo_z : heights)
          for (const float wi_z : heights)
            for (const float turn : {-1.0F, 0.0F, 1.0F}) {
              const float wo_r = std::sqrt(1 - wo_z * wo_z), wi_r = std::sqrt(1 - wi_z * wi_z);
              const Direction wi = {turn * wi_r, turn == 0 ? wi_r : 0, wi_z};
              for (const float choice : {0.01F, 0.5F, 0.99F}) q.add(which, {wo_r, 0, wo_z}, wi, 0.4F, 0.6F, choice);
            }
      const Answers answers = scatter(all, q, uniform_scatter);
      for (std::size_t i = 0; i < q.size(); ++i) {
        const Specimen& specimen = all[q.in[0][i]];
        const float wo_z = as_float(q.in[3][i]), wi_z = as_float(q.in[6][i]);
        SCOPED_TRACE(specimen.name + ", roughness " + std::to_string(roughness) + ", wo.z " + std::to_string(wo_z) +
                     ", wi.z " + std::to_string(wi_z));
        for (std::size_t k = 0; k < 15; ++k) ASSERT_TRUE(std::isfinite(as_float(answers.out[k][i]))) << "output " << k;
        for (std::size_t k = 0; k < 4; ++k) {
          ASSERT_GE(as_float(answers.out[k][i]), 0);
          const bool may_scatter_below = specimen.lets_through() || specimen.has_leaning_base();
          if (wo_z <= 0 || (wi_z == 0 && !specimen.has_leaning_base()) || (wi_z < 0 && !may_scatter_below)) {
            ASSERT_EQ(as_float(answers.out[k][i]), 0);
          }
        }
        const Sampled s = answers.sample(i);
        if (wo_z <= 0) {
          ASSERT_EQ(s.pdf, 0);
        }
        if (s.pdf > 0 && !specimen.lets_through() && !specimen.has_leaning_base()) {
          ASSERT_GT(s.wi[2], 0);
        }
      }
    }
  }
}

TEST(Bsdf, N2_the_ends_of_the_unit_interval_are_samples_like_any_other) {
  for (const float roughness : kRoughnesses) {
    const auto all = specimens(roughness);
    Queries q;
    for (std::uint32_t which = 0; which < all.size(); ++which)
      for (const double angle : {0.0, 30.0, 85.0})
        for (const float u : {0.0F, 1 - 0x1p-24F})
          for (const float v : {0.0F, 1 - 0x1p-24F})
            for (const float choice : {0.0F, 0.5F, 1 - 0x1p-24F})
              q.add(which, from_angle(angle, 0), {0, 0, 1}, u, v, choice);
    const Answers answers = scatter(all, q);
    for (std::size_t i = 0; i < q.size(); ++i)
      for (std::size_t k = 4; k < 11; ++k)
        ASSERT_TRUE(std::isfinite(as_float(answers.out[k][i])))
            << all[q.in[0][i]].name << ", query " << i << ", output " << k;
  }
}

TEST(Bsdf, a_material_without_lobes_is_black_and_still_emits) {
  MaterialRecord lamp{};
  lamp.emission_r = 17;
  lamp.emission_g = 12;
  lamp.emission_b = 4;
  lamp.flags = EK_MATERIAL_DOUBLE_SIDED;
  lamp.base_color_texture = lamp.metallic_roughness_texture = lamp.emissive_texture = EK_NO_TEXTURE;
  MaterialExtension plain{};
  plain.transmission_texture = plain.specular_texture = plain.specular_color_texture = EK_NO_TEXTURE;
  MaterialDetail bare{};
  bare.clearcoat_texture = bare.clearcoat_roughness_texture = bare.clearcoat_normal_texture = EK_NO_TEXTURE;
  bare.sheen_color_texture = bare.sheen_roughness_texture = bare.anisotropy_texture = EK_NO_TEXTURE;
  bare.diffuse_transmission_texture = bare.diffuse_transmission_color_texture = EK_NO_TEXTURE;
  Queries q;
  q.add(0, from_angle(20, 0), from_angle(50, 0.5), 0.2F, 0.9F, 0.5F);
  const auto out = scatter({lamp}, {plain}, {bare}, q, false);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(as_float(out[k][0]), 0);
  EXPECT_EQ(as_float(out[10][0]), 0) << "nothing may be sampled";
  EXPECT_EQ(as_float(out[15][0]), 17);
  EXPECT_EQ(as_float(out[16][0]), 12);
  EXPECT_EQ(as_float(out[17][0]), 4);
  EXPECT_EQ(out[18][0], 1U);
}

}  // namespace
}  // namespace eikon::test
