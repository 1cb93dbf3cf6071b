// SPDX-License-Identifier: Apache-2.0
// What KHR_materials_specular does to solids, and thin films to materials that are partly metal.
#include <gtest/gtest.h>

#include "kernels/bsdf/bsdf_probe.h"

namespace eikon::test {
namespace {

/// Reflectance of a smooth dielectric by Fresnel's equations. eta: far side over near side
double fresnel(double cosine, double eta) {
  const double g2 = eta * eta - 1 + cosine * cosine;
  if (g2 <= 0) return 1;
  const double g = std::sqrt(g2);
  const double across = (cosine - g) / (cosine + g), along = (eta * eta * cosine - g) / (eta * eta * cosine + g);
  return (across * across + along * along) / 2;
}

/// Shares of light that a smooth solid reflects and transmits in each channel.
struct ColorShares {
  std::array<double, 3> reflected{}, transmitted{};
};
std::vector<ColorShares> shares_of(const std::vector<Specimen>& all, const Direction& wo) {
  Queries q;
  for (std::uint32_t which = 0; which < all.size(); ++which)
    for (const float choice : {0.0F, 1 - 0x1p-24F}) q.add(which, wo, {0, 0, 1}, 0.3F, 0.6F, choice);
  const Answers answers = scatter(all, q);
  std::vector<ColorShares> shares(all.size());
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    if (s.pdf <= 0) continue;
    EXPECT_TRUE(s.delta);
    const double eta = all[i / 2].eta();
    for (std::size_t c = 0; c < 3; ++c)
      (s.wi[2] > 0 ? shares[i / 2].reflected : shares[i / 2].transmitted)[c] =
          s.weight[c] * s.pdf * (s.wi[2] > 0 ? 1 : eta * eta);
  }
  return shares;
}

TEST(SolidSpecular, reflectance_goes_from_f0_to_f90_as_fresnels_equations_and_the_rest_passes) {
  ProbeMaterial usual{.roughness = 0, .transmission = 1, .solid = true};
  ProbeMaterial none = usual, red = usual, strong = usual;
  none.specular = 0;
  red.specular_color = {1, 0, 0};
  strong.specular = 0.6F;
  strong.specular_color = {3, 0.5F, 40};
  for (const float ior : {1.33F, 1.5F, 2.4F})
    for (const bool front : {true, false}) {
      std::vector<Specimen> all;
      for (ProbeMaterial material : {usual, none, red, strong}) {
        material.ior = ior;
        all.push_back({"solid", kLobe_transmission, material, front});
      }
      for (const double angle : {0.0, 20.0, 50.0, 70.0, 88.0}) {
        const Direction wo = from_angle(angle, 0.2);
        const double eta = all[0].eta(), exact = fresnel(double(wo[2]), eta);
        const double f0 = std::pow((eta - 1) / (eta + 1), 2), weight = (exact - f0) / (1 - f0);
        const std::vector<ColorShares> found = shares_of(all, wo);
        for (std::size_t which = 0; which < all.size(); ++which)
          for (std::size_t c = 0; c < 3; ++c) {
            const ProbeMaterial& m = all[which].material;
            const double least = std::min(1.0, f0 * double(m.specular_color[c])) * double(m.specular);
            const double expected = exact < 1 ? least + (double(m.specular) - least) * weight : 1;
            SCOPED_TRACE("ior " + std::to_string(ior) + (front ? "" : ", from inside") + ", " + std::to_string(angle) +
                         " degrees, specimen " + std::to_string(which) + ", channel " + std::to_string(c));
            EXPECT_NEAR(found[which].reflected[c], expected, 2e-6 + 4e-6 * expected);
            EXPECT_NEAR(found[which].transmitted[c], 1 - expected, 4e-6);
          }
      }
    }
}

TEST(SolidSpecular, a_mirrors_index_reflects_what_the_extension_says) {
  ProbeMaterial dark{.roughness = 0, .ior = 0, .specular = 0.5F, .specular_color = {1, 0.5F, 0}};
  dark.transmission = 1, dark.solid = true;
  const ColorShares found = shares_of({{"mirror", kLobe_transmission, dark}}, {0, 0, 1})[0];
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.reflected[c], 0.5 * double(dark.specular_color[c]), 1e-6);
}

TEST(ThinFilmMix, a_material_that_is_partly_metal_shows_the_mean_of_a_film_on_either) {
  for (const float index : {1.3F, 1.8F})
    for (const float transmission : {0.0F, 0.4F}) {
      ProbeMaterial material{.base_color = {1, 0.8F, 0.3F}, .roughness = 0.3F, .transmission = transmission};
      material.iridescence = 0.9F;
      material.thin_film_index = index;
      material.thin_film_nm = 400;
      std::vector<Specimen> all;
      for (const float metallic : {0.0F, 1.0F, 0.25F, 0.7F}) {
        material.metallic = metallic;
        all.push_back({"mix", transmission > 0 ? kLobe_transmission : kLobe_metallic_roughness, material});
      }
      std::mt19937 random(5);
      Queries q;
      for (int i = 0; i < 400; ++i) {
        const Direction wo = from_cosine(0.05 + 0.95 * uniform(random), uniform(random)),
                        wi = from_cosine(0.05 + 0.95 * uniform(random), uniform(random));
        for (std::uint32_t which = 0; which < all.size(); ++which) q.add(which, wo, wi, 0, 0, 0);
      }
      const Answers answers = scatter(all, q);
      for (std::size_t i = 0; i < q.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c)
          for (const std::size_t which : {2U, 3U}) {
            const double metallic = double(all[which].material.metallic);
            const double expected = (1 - metallic) * answers.eval(i, c) + metallic * answers.eval(i + 1, c);
            ASSERT_NEAR(answers.eval(i + which, c), expected, 1e-5 * expected + 1e-7)
                << "index " << index << ", transmission " << transmission << ", metallic " << metallic;
          }
    }
}

}  // namespace
}  // namespace eikon::test
