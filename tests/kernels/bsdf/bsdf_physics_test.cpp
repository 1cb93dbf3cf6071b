// SPDX-License-Identifier: Apache-2.0
// Lobes against what is known in closed form: Fresnel, GGX's albedo, slabs, mirrors, and furnaces.
#include <gtest/gtest.h>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

std::vector<double> fresnel(const std::vector<double>& cosines, double eta) {
  std::vector<float> c, n;
  for (const double x : cosines) {
    c.push_back(float(x));
    n.push_back(float(eta));
  }
  std::vector<double> f;
  const auto out = Probe("bsdf").run("probe_fresnel", {as_words(c), as_words(n)}, 1);
  for (const std::uint32_t word : out[0]) f.push_back(as_float(word));
  return f;
}

double cos_deg(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

/// One specimen with the lobe of a name of features.def.
Specimen specimen_of(const std::string& name, const ProbeMaterial& material, bool front = true) {
#define EK_LOBE(lobe, bit, traits) \
  if (name == #lobe) return {#lobe, bit, material, front};
#include "shared/features.def"
  throw std::logic_error("no such lobe");
}

/// The mean weight of each channel of specimen `which` seen from wo, and its standard error.
std::array<Mean, 3> albedo(const std::vector<Specimen>& all, std::uint32_t which, const std::vector<Direction>& wo,
                           unsigned seed) {
  std::mt19937 random(seed);
  Queries q;
  for (const Direction& w : wo) q.add(which, w, random);
  const Answers answers = scatter(all, q);
  std::array<Mean, 3> mean;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> weights;
    for (std::size_t i = 0; i < q.size(); ++i) weights.push_back(answers.sample(i).weight[c]);
    mean[c] = mean_of(weights);
  }
  return mean;
}

TEST(BsdfPhysics, M9_dielectric_reflectance_has_the_listed_values) {
  const double degrees[] = {0, 45, 60, 80, 85, 89, 56.3099};
  const double listed[] = {.04, .0502399, .0891867, .387704, .612800, .904185, .0739645};
  std::vector<double> cosines;
  for (const double d : degrees) cosines.push_back(cos_deg(d));
  const auto f = fresnel(cosines, 1.5);
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(f[i], listed[i], 1.5e-6) << degrees[i] << " degrees";
  // From inside: Snell's angles give the same; from the critical angle on everything is reflected.
  std::vector<double> inside;
  for (const double d : degrees)
    inside.push_back(std::sqrt(1 - std::pow(std::sin(d * std::numbers::pi / 180) / 1.5, 2)));
  const auto g = fresnel(inside, 1 / 1.5);
  for (std::size_t i = 0; i < g.size(); ++i)
    EXPECT_NEAR(g[i], listed[i], 3e-5) << degrees[i] << " degrees, from inside";
  for (const double total : fresnel({cos_deg(41.8104), cos_deg(45), cos_deg(60), cos_deg(89.9), 0}, 1 / 1.5))
    EXPECT_EQ(total, 1);
  EXPECT_LT(fresnel({cos_deg(41.80)}, 1 / 1.5)[0], 1);
}

TEST(BsdfPhysics, M10_the_hemispherical_reflectance_is_that_of_the_integral) {
  std::vector<double> cosines;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) cosines.push_back((i + 0.5) / kSteps);
  for (const auto& [eta, listed] : {std::pair(1.5, .0917780), std::pair(1 / 1.5, .596346)}) {
    const auto f = fresnel(cosines, eta);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += 2 * f[std::size_t(i)] * cosines[std::size_t(i)] / kSteps;
    EXPECT_NEAR(sum, listed, 2e-6) << "eta " << eta;
  }
}

/// Shares of light that a smooth surface reflects and transmits, by its delta samples: weight times
/// probability.
struct Shares {
  double reflected = 0, transmitted = 0;
};
Shares delta_shares(const Specimen& specimen, const Direction& wo) {
  Queries q;
  q.add(0, wo, {0, 0, 1}, 0.3F, 0.6F, 0);
  q.add(0, wo, {0, 0, 1}, 0.3F, 0.6F, 1 - 0x1p-24F);
  const Answers answers = scatter({specimen}, q);
  Shares shares;
  for (std::size_t i = 0; i < 2; ++i) {
    const Sampled s = answers.sample(i);
    EXPECT_TRUE(s.delta);
    (s.wi[2] > 0 ? shares.reflected : shares.transmitted) = s.weight[0] * s.pdf;
  }
  return shares;
}

TEST(BsdfPhysics, M11_a_slab_of_glass_passes_12_of_13_parts) {
  const ProbeMaterial glass{.roughness = 0, .transmission = 1, .solid = true};
  const Shares outside = delta_shares(specimen_of("transmission", glass), {0, 0, 1});
  const Shares inside = delta_shares(specimen_of("transmission", glass, false), {0, 0, 1});
  EXPECT_NEAR(outside.reflected, .04, 1e-7);
  EXPECT_NEAR(outside.transmitted, .96 / 2.25, 1e-6) << "radiance shrinks by eta^2";
  const double bounces = 1 / (1 - inside.reflected * inside.reflected);
  EXPECT_NEAR(outside.transmitted * bounces * inside.transmitted, 12.0 / 13, 1e-6);
  EXPECT_NEAR(outside.reflected + outside.transmitted * inside.reflected * bounces * inside.transmitted, 1.0 / 13,
              1e-6);
}

TEST(BsdfPhysics, M13_extreme_indices_are_invisible_or_mirrors_and_always_finite) {
  for (const float roughness : {0.0F, 0.3F, 1.0F})
    for (const bool front : {true, false}) {
      ProbeMaterial material{.base_color = {0.25F, 0.5F, 1}, .roughness = roughness, .transmission = 1, .solid = true};
      std::vector<Specimen> all;
      for (const float ior : {1.0F, 1 + 1e-6F, 1e9F, 0.0F, 1e-12F}) {
        material.ior = ior;
        all.push_back(specimen_of("transmission", material, front));
      }
      std::mt19937 random(11);
      Queries q;
      for (int i = 0; i < 5000; ++i) {
        const Direction wo = from_cosine(0.01 + 0.99 * uniform(random), uniform(random));
        for (std::uint32_t which = 0; which < all.size(); ++which) q.add(which, wo, random);
      }
      const Answers answers = scatter(all, q);
      for (std::size_t i = 0; i < q.size(); ++i) {
        const std::size_t which = q.in[0][i];
        const Sampled s = answers.sample(i);
        SCOPED_TRACE("ior " + std::to_string(all[which].material.ior) + ", roughness " + std::to_string(roughness));
        for (std::size_t c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(s.weight[c]) && std::isfinite(s.wi[c]));
        if (which == 0) {
          for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_EQ(s.wi[k], -as_float(q.in[1 + k][i]));
            ASSERT_NEAR(s.weight[k], material.base_color[k], 1e-6);
          }
          ASSERT_NEAR(s.pdf, 1, 1e-6);
        } else if (which == 1) {
          if (s.wi[2] < 0) {
            for (std::size_t k = 0; k < 3; ++k) {
              ASSERT_NEAR(s.wi[k], -as_float(q.in[1 + k][i]), 1e-4);
              ASSERT_NEAR(s.weight[k], material.base_color[k], 1e-4);
            }
          }
        } else if (s.pdf > 0) {
          ASSERT_GT(s.wi[2], 0) << "a mirror";
          for (std::size_t c = 0; c < 3 && roughness == 0; ++c) {
            ASSERT_NEAR(s.weight[c], 1, 1e-6);
          }
        }
      }
    }
  // Opaque surfaces of ior 0 reflect everything, too, whatever lies below.
  const auto white = albedo({specimen_of("metallic_roughness", {.base_color = {0, 1, 0.5F}, .roughness = 0, .ior = 0})},
                            0, std::vector<Direction>(1000, from_angle(40, 0.2)), 12);
  for (const Mean& m : white) EXPECT_NEAR(m.mean, 1, 1e-6);
}

TEST(BsdfPhysics, M3_the_lobe_that_reflects_everything_has_the_albedo_of_single_scattering) {
  constexpr std::size_t kSamples = 1000000;
  const std::pair<double, double> listed[] = {{1, .306852819}, {.5, .687850}, {.25, .915812}, {.1, .988304}};
  const std::pair<double, double> means[] = {{1, .4091}, {.5, .7002}, {.1, .9720}};
  for (const auto& [alpha, expected] : listed) {
    const std::vector all{specimen_of("metallic_roughness", {.metallic = 1, .roughness = float(std::sqrt(alpha))})};
    const Mean m = albedo(all, 0, std::vector<Direction>(kSamples, {0, 0, 1}), 21)[0];
    EXPECT_NEAR(m.mean, expected, 4 * m.standard_error + 5e-7) << "alpha " << alpha;
  }
  for (const auto& [alpha, expected] : means) {
    const std::vector all{specimen_of("metallic_roughness", {.metallic = 1, .roughness = float(std::sqrt(alpha))})};
    std::vector<Direction> wo;
    for (std::size_t i = 0; i < kSamples; ++i)
      wo.push_back(from_cosine(std::sqrt((double(i) + 0.5) / double(kSamples)), double(i) * 0.6180339887));
    EXPECT_NEAR(albedo(all, 0, wo, 22)[0].mean, expected, 1e-3) << "alpha " << alpha;
  }
}

TEST(BsdfPhysics, the_fitted_albedos_are_never_less_than_what_the_lobe_reflects_and_little_more) {
  // With specular 1, f0 is 0 for ior 1: what is left is the grazing part.
  constexpr std::size_t kSamples = 200000;
  double full_most = 0, grazing_most = 0;
  for (const float roughness : {0.0F, 0.0111F, 0.03F, 0.1F, 0.2F, 0.35F, 0.6F, 0.8F, 1.0F})
    for (const double c : {0.001, 0.02, 0.1, 0.3, 0.7, 1.0}) {
      const std::vector all{
          specimen_of("metallic_roughness", {.metallic = 1, .roughness = roughness}),
          specimen_of("metallic_roughness", {.base_color = {0, 0, 0}, .roughness = roughness, .ior = 1})};
      const Direction wo = from_cosine(c, 0.3);
      const Mean full = albedo(all, 0, std::vector<Direction>(kSamples, wo), 31)[0];
      const Mean grazing = albedo(all, 1, std::vector<Direction>(kSamples, wo), 32)[0];
      const auto fit = Probe("bsdf").run(
          "probe_ggx_albedo",
          {as_words({roughness * roughness}), as_words({wo[0]}), as_words({wo[1]}), as_words({wo[2]})}, 4);
      const double fitted_full = as_float(fit[0][0]), fitted_grazing = as_float(fit[1][0]);
      SCOPED_TRACE("roughness " + std::to_string(roughness) + ", cosine " + std::to_string(c));
      EXPECT_GE(fitted_full, full.mean - 4 * full.standard_error - 1e-6);
      EXPECT_LE(fitted_full, full.mean + 4 * full.standard_error + 0.022);
      EXPECT_GE(fitted_grazing, grazing.mean - 4 * grazing.standard_error - 1e-6);
      EXPECT_LE(fitted_grazing, grazing.mean + 4 * grazing.standard_error + 0.005);
      full_most = std::max(full_most, fitted_full - full.mean);
      grazing_most = std::max(grazing_most, fitted_grazing - grazing.mean);
    }
  std::printf("the fits are above by at most %.4f and %.4f\n", full_most, grazing_most);
}

TEST(BsdfPhysics, M4_white_plastic_returns_all_light_when_smooth_and_all_but_a_little_when_rough) {
  for (const float roughness : {0.0F, 0.05F, 0.1F, 0.2F, 0.4F, 0.7F, 1.0F})
    for (const double angle : {0.0, 45.0, 80.0, 87.0, 89.9}) {
      const std::vector all{specimen_of("metallic_roughness", {.roughness = roughness})};
      const Mean m = albedo(all, 0, std::vector<Direction>(300000, from_angle(angle, 0.4)), 41)[0];
      SCOPED_TRACE("roughness " + std::to_string(roughness) + ", " + std::to_string(angle) + " degrees");
      EXPECT_LE(m.mean, 1 + 4 * m.standard_error + 1e-6);
      EXPECT_GE(m.mean, (roughness == 0 ? 1 - 2e-6 : 0.993) - 4 * m.standard_error);
    }
}

TEST(BsdfPhysics, M7_towards_smoothness_a_surface_becomes_the_mirror_without_a_step) {
  // The peak: at normal incidence eval is D / 4.
  Queries peak;
  peak.add(0, {0, 0, 1}, {0, 0, 1}, 0, 0, 0);
  const std::vector sharp{specimen_of("metallic_roughness", {.metallic = 1, .roughness = std::sqrt(1e-3F)})};
  EXPECT_NEAR(4 * scatter(sharp, peak).eval(0, 0), 1 / (std::numbers::pi * 1e-6), 1);
  // What surfaces show of a sky that varies, on both sides of the switch to delta at alpha = 2^-13
  // and far from it.
  const auto sky = [](const std::array<double, 3>& w) { return std::pow(1 + 0.6 * w[0] - 0.3 * w[1] + 0.5 * w[2], 2); };
  constexpr int kSamples = 200000;
  const auto shows = [&](const ProbeMaterial& material, const char* lobe, double angle) {
    const std::vector all{specimen_of(lobe, material)};
    std::mt19937 random(51);
    Queries q;
    q.draw(kSamples, 0, from_angle(angle, 0.15), random);
    const Answers answers = scatter(all, q);
    std::vector<double> radiance;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Sampled s = answers.sample(i);
      radiance.push_back(s.pdf > 0 ? s.weight[0] * sky(s.wi) : 0);
    }
    return mean_of(radiance);
  };
  const float edge = std::sqrt(0x1p-13F);
  for (const auto& [lobe, material] :
       {std::pair("metallic_roughness", ProbeMaterial{.metallic = 1}), std::pair("metallic_roughness", ProbeMaterial{}),
        std::pair("transmission", ProbeMaterial{.transmission = 1}),
        std::pair("transmission", ProbeMaterial{.transmission = 1, .solid = true})})
    for (const double angle : {0.0, 45.0, 80.0}) {
      SCOPED_TRACE(std::string(lobe) + (material.solid ? ", solid" : "") + ", " + std::to_string(angle) + " degrees");
      ProbeMaterial at = material;
      at.roughness = 0;
      const Mean mirror = shows(at, lobe, angle);
      for (const float roughness : {1e-10F, 1e-6F, 1e-3F, edge * 0.999F, edge * 1.001F}) {
        at.roughness = roughness;
        const Mean m = shows(at, lobe, angle);
        EXPECT_NEAR(m.mean, mirror.mean, 0.004 * mirror.mean + 4 * std::hypot(m.standard_error, mirror.standard_error))
            << roughness;
      }
      at.roughness = 0.1F;
      EXPECT_NEAR(shows(at, lobe, angle).mean, mirror.mean, 0.02 * mirror.mean) << "and from afar";
    }
}

TEST(BsdfPhysics, M17_a_metal_is_exactly_schlicks_mirror_of_its_base_color) {
  const ProbeMaterial material{.base_color = {0.5F, 0.9F, 0.02F}, .metallic = 1, .roughness = 0};
  const std::vector all{specimen_of("metallic_roughness", material)};
  Queries q;
  std::mt19937 random(61);
  q.add(0, {0, 0, 1}, random);
  for (int i = 0; i < 20000; ++i) q.add(0, from_cosine(1 - uniform(random), uniform(random)), random);
  const Answers answers = scatter(all, q);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_EQ(answers.sample(0).weight[c], material.base_color[c]) << "normal incidence";
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    ASSERT_TRUE(s.delta);
    ASSERT_EQ(s.pdf, 1);
    const double grazing = std::pow(1 - double(as_float(q.in[3][i])), 5);
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(s.weight[c], material.base_color[c] + (1 - material.base_color[c]) * grazing, 3e-7);
  }
  // The same at every microfacet of a rough one: eval over that of the lobe that reflects
  // everything.
  ProbeMaterial rough = material, white = material;
  rough.roughness = white.roughness = 0.4F;
  white.base_color = {1, 1, 1};
  Queries pairs;
  std::vector<double> grazing;
  for (int i = 0; i < 20000; ++i) {
    const Direction wo = from_cosine(0.05 + 0.95 * uniform(random), uniform(random)),
                    wi = from_cosine(0.05 + 0.95 * uniform(random), uniform(random));
    double sum2 = 0;
    for (std::size_t k = 0; k < 3; ++k) sum2 += std::pow(double(wo[k]) + wi[k], 2);
    grazing.push_back(std::pow(1 - std::sqrt(sum2) / 2, 5));
    pairs.add(0, wo, wi, 0, 0, 0);
    pairs.add(1, wo, wi, 0, 0, 0);
  }
  const Answers both =
      scatter({specimen_of("metallic_roughness", rough), specimen_of("metallic_roughness", white)}, pairs);
  for (std::size_t i = 0; i < grazing.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected = material.base_color[c] + (1 - material.base_color[c]) * grazing[i];
      ASSERT_NEAR(both.eval(2 * i, c) / both.eval(2 * i + 1, c), expected, 1e-6);
    }
}

TEST(BsdfPhysics, M18_facing_mirrors_lose_a_tenth_each_time) {
  const Shares mirror = [] {
    const std::vector all{
        specimen_of("metallic_roughness", {.base_color = {0.9F, 0.9F, 0.9F}, .metallic = 1, .roughness = 0})};
    Queries q;
    q.add(0, {0, 0, 1}, {0, 0, 1}, 0.5F, 0.5F, 0.5F);
    return Shares{scatter(all, q).sample(0).weight[0], 0};
  }();
  EXPECT_NEAR(std::pow(mirror.reflected, 10), .348678, 1e-6);
}

}  // namespace
}  // namespace eikon::test
