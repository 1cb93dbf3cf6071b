// SPDX-License-Identifier: Apache-2.0
// Anisotropic microfacets, and conductors by their index of refraction.
#include <gtest/gtest.h>

#include <complex>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

std::vector<double> conductor(const std::vector<std::array<double, 3>>& cosine_eta_k) {
  std::vector<Words> in(3);
  for (const auto& query : cosine_eta_k)
    for (std::size_t k = 0; k < 3; ++k) in[k].push_back(as_word(float(query[k])));
  std::vector<double> f;
  const Words out = Probe("bsdf").run("probe_fresnel_conductor", in, 1)[0];
  for (const std::uint32_t word : out) f.push_back(as_float(word));
  return f;
}

double by_complex_numbers(double cosine, std::complex<double> n) {
  const std::complex<double> sine2 = 1 - cosine * cosine, g = std::sqrt(n * n - sine2);
  return 0.5 * (std::norm((cosine - g) / (cosine + g)) + std::norm((n * n * cosine - g) / (n * n * cosine + g)));
}

TEST(Conductor, M14_metals_reflect_as_listed_at_normal_incidence) {
  const std::array<double, 3> gold_red{1, 0.16779, 3.137816}, gold_green{1, 0.350409, 2.714063},
      gold_blue{1, 1.508458, 1.87885}, copper{1, 0.958162, 2.577065}, silver{1, 0.124777, 3.3396},
      aluminium{1, 0.958569, 6.686968};
  const auto f = conductor({gold_blue, gold_green, gold_red, copper, silver, aluminium});
  const double listed[] = {.38571, .84748, .94013, .63414, .95981, .92103};
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(f[i], listed[i], 6e-6) << i;
}

TEST(Conductor, M14_reflectance_is_that_of_complex_arithmetic_at_every_angle_and_index) {
  std::mt19937 random(1);
  std::vector<std::array<double, 3>> queries;
  for (int i = 0; i < 100000; ++i)
    queries.push_back({uniform(random), float(std::exp(12.0 * uniform(random) - 6)),
                       i % 4 == 0 ? 0 : float(std::exp(12.0 * uniform(random) - 6))});
  const auto f = conductor(queries);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const auto& [cosine, eta, k] = queries[i];
    const double exact = by_complex_numbers(cosine, {eta, k});
    // Next to a critical angle the reflectance rises without bound: what two units in the last
    // place of the input change counts.
    double conditioned = 0;
    for (const double scale : {1 - 0x1p-22, 1 + 0x1p-22})
      for (const double moved :
           {by_complex_numbers(std::min(cosine * scale, 1.0), {eta, k}), by_complex_numbers(cosine, {eta * scale, k})})
        conditioned = std::max(conditioned, std::abs(moved - exact));
    ASSERT_NEAR(f[i], exact, 3e-6 + conditioned) << cosine << " " << eta << " " << k;
  }
  for (const double g :
       conductor({{1, 0, 0}, {0, 0, 0}, {0.5, 0, 0}, {0, 1.5, 2}, {1, 0, 5}, {1, 16384, 16384}, {0.1, 0, 16384}})) {
    EXPECT_TRUE(g >= 0 && g <= 1) << g;
  }
}

TEST(Conductor, M14_without_absorption_it_is_a_dielectric) {
  std::vector<std::array<double, 3>> queries;
  Words cosines, etas;
  for (const double eta : {1.1, 1.5, 2.4, 0.75})
    for (int i = 0; i <= 90; ++i) {
      queries.push_back({std::cos(i * std::numbers::pi / 180), eta, 0});
      cosines.push_back(as_word(float(queries.back()[0])));
      etas.push_back(as_word(float(eta)));
    }
  const auto f = conductor(queries);
  const auto dielectric = Probe("bsdf").run("probe_fresnel", {cosines, etas}, 1);
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(f[i], as_float(dielectric[0][i]), 2e-6) << i;
}

TEST(Conductor, a_smooth_one_is_a_mirror_of_that_reflectance) {
  ProbeMaterial gold{.metallic = 1, .roughness = 0};
  gold.eta = {0.16779F, 0.350409F, 1.508458F};
  gold.k = {3.137816F, 2.714063F, 1.87885F};
  Queries q;
  for (int i = 0; i < 90; ++i) q.add(0, from_angle(i, 0.3), {0, 0, 1}, 0.1F, 0.2F, 0.3F);
  const Answers answers = scatter({{"gold", kLobe_conductor, gold}}, q);
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    ASSERT_TRUE(s.delta);
    ASSERT_EQ(s.pdf, 1);
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(s.weight[c], by_complex_numbers(as_float(q.in[3][i]), {gold.eta[c], gold.k[c]}), 3e-6);
  }
}

Specimen brushed(float roughness_x, float roughness_y, float metallic = 1) {
  ProbeMaterial material{.base_color = {1, 1, 1}, .metallic = metallic, .roughness = roughness_y};
  material.roughness_x = roughness_x;
  return {"brushed", kLobe_metallic_roughness, material};
}

Direction swapped(const Direction& w) { return {w[1], w[0], w[2]}; }

TEST(Anisotropy, M21_axes_swapped_and_surface_turned_by_90_degrees_are_the_same) {
  const float rough = 1, sharp = std::sqrt(1e-3F);  // alpha 1000 : 1
  for (const float metallic : {0.0F, 1.0F}) {
    std::mt19937 random(2);
    Queries q;
    for (int i = 0; i < 50000; ++i) {
      const Direction wo = from_cosine(1 - uniform(random), uniform(random)),
                      wi = from_cosine(1 - uniform(random), uniform(random));
      q.add(0, wo, wi, 0, 0, 0);
      q.add(1, swapped(wo), swapped(wi), 0, 0, 0);
    }
    const Answers answers = scatter({brushed(rough, sharp, metallic), brushed(sharp, rough, metallic)}, q);
    for (std::size_t i = 0; i < q.size(); i += 2) {
      ASSERT_NEAR(answers.eval(i, 0), answers.eval(i + 1, 0), 2e-6 * answers.eval(i, 0) + 1e-30);
      ASSERT_NEAR(answers.pdf(i), answers.pdf(i + 1), 2e-6 * answers.pdf(i) + 1e-30);
    }
  }
}

TEST(Anisotropy, M21_a_ratio_of_1_is_isotropic) {
  for (const float roughness : {0.0F, 0.05F, 0.3F, 1.0F}) {
    std::mt19937 random(3);
    Queries q;
    for (int i = 0; i < 20000; ++i)
      q.add(std::uint32_t(i % 2), from_cosine(1 - uniform(random), uniform(random)),
            from_cosine(1 - uniform(random), uniform(random)), uniform(random), uniform(random), uniform(random));
    const std::vector all{brushed(-1, roughness), brushed(-1, roughness, 0)};
    const Answers one = scatter(all, q, false, true), other = scatter(all, q, false, false);
    for (std::size_t i = 0; i < q.size(); ++i) {
      ASSERT_NEAR(one.eval(i, 0), other.eval(i, 0), 1e-5 * other.eval(i, 0) + 1e-30);
      ASSERT_NEAR(one.pdf(i), other.pdf(i), 1e-5 * other.pdf(i) + 1e-30);
      const Sampled a = one.sample(i), b = other.sample(i);
      ASSERT_NEAR(a.weight[0], b.weight[0], 1e-5 * b.weight[0] + 1e-6);
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(a.wi[k], b.wi[k], 1e-5);
    }
  }
}

// The albedo of one lobe two ways: the mean weight of its own samples, and by sampling the cosine.
TEST(Anisotropy, M21_samples_at_a_ratio_of_1000_to_1_bring_back_what_the_lobe_reflects) {
  for (const double angle : {0.0, 45.0, 80.0})
    for (const double turn : {0.0, 0.125, 0.25}) {
      std::mt19937 random(4);
      const std::vector all{brushed(1, std::sqrt(1e-3F))};
      Queries q, grid;
      const Direction wo = from_angle(angle, turn);
      q.draw(200000, 0, wo, random);
      // By half vectors: slopes of the distribution, tan(theta_h) cos(phi_h) = alpha.x s, ... on a
      // grid of the disk.
      const Answers answers = scatter(all, q);
      std::vector<double> weights;
      for (std::size_t i = 0; i < q.size(); ++i)
        weights.push_back(answers.sample(i).pdf > 0 ? answers.sample(i).weight[0] : 0);
      const Mean sampled = mean_of(weights);
      std::vector<double> jacobian;
      constexpr int kSteps = 700;
      for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
          // Density of slopes ~ 1 / (1 + r^2)^2: r^2 = u / (1 - u) is uniform under it.
          const double u = (i + 0.5) / kSteps, phi = (j + 0.5) / kSteps * 2 * std::numbers::pi,
                       r = std::sqrt(u / (1 - u));
          const double x = r * std::cos(phi), y = 1e-3 * r * std::sin(phi), length = std::sqrt(1 + x * x + y * y);
          const std::array<double, 3> h{x / length, y / length, 1 / length};
          const double along = h[0] * wo[0] + h[1] * wo[1] + h[2] * wo[2];
          const Direction wi{float(2 * along * h[0] - wo[0]), float(2 * along * h[1] - wo[1]),
                             float(2 * along * h[2] - wo[2])};
          if (along <= 0 || wi[2] <= 0) continue;
          // D(h) cos_h is the density of h per sr; 4 |wo . h| sr of wi for each of it.
          const double d =
              std::pow(1 + x * x + (y / 1e-3) * (y / 1e-3), -2) / (std::numbers::pi * 1e-3) / std::pow(h[2], 4);
          grid.add(0, wo, wi, 0, 0, 0);
          jacobian.push_back(4 * along / (d * h[2]) / (double(kSteps) * kSteps));
        }
      const Answers stated = scatter(all, grid);
      double sum = 0;
      for (std::size_t i = 0; i < jacobian.size(); ++i) sum += stated.eval(i, 0) * jacobian[i];
      EXPECT_NEAR(sampled.mean, sum, 4 * sampled.standard_error + 0.01 * sum)
          << angle << " degrees, turned by " << turn;
      EXPECT_LE(sampled.mean, 1 + 4 * sampled.standard_error);
    }
}

// Of a layer of reflectance .04 the tables say at most .04 * .109 + .96 * .169 more than the truth,
// and the mean over all directions at most .0125 less than that of what they say
// (tools/tables/make_anisotropy_table.py --check): both at grazing angles.
TEST(Anisotropy, a_white_base_under_a_brushed_layer_gives_back_no_more_than_arrives) {
  std::mt19937 random(5);
  for (const auto& [x, y] : {std::pair(1.0F, 0.0F), std::pair(1.0F, 0.1F), std::pair(0.7F, 0.2F),
                             std::pair(0.5F, 0.03F), std::pair(1.0F, 0.6F)})
    for (const double angle : {0.0, 30.0, 60.0, 80.0, 87.0, 89.5})
      for (const double turn : {0.0, 0.125, 0.25}) {
        Queries q;
        q.draw(100000, 0, from_angle(angle, turn), random);
        const Answers answers = scatter({brushed(x, y, 0)}, q);
        std::vector<double> weights;
        for (std::size_t i = 0; i < q.size(); ++i)
          weights.push_back(answers.sample(i).pdf > 0 ? answers.sample(i).weight[0] : 0);
        const Mean m = mean_of(weights);
        EXPECT_LE(m.mean, 1 + 4 * m.standard_error + 1e-6) << x << " " << y << " " << angle << " " << turn;
        EXPECT_GE(m.mean, (angle > 80 ? 0.82 : 0.9) - 4 * m.standard_error)
            << x << " " << y << " " << angle << " " << turn;
      }
}

}  // namespace
}  // namespace eikon::test
