// SPDX-License-Identifier: Apache-2.0
// A coat has a normal of its own: that of the mesh, or of the coat's own map, in whatever way a map
// turns the normal of what lies below.
#include "render/materials/leaning_floor.h"

namespace eikon::test {
namespace {

Material coated(float albedo, float roughness) {
  Material material = lambert(albedo);
  material.clearcoat = 1;
  material.clearcoat_roughness = roughness;
  return material;
}

double coat_reflectance(double cosine) { return 0.04 + 0.96 * std::pow(1 - cosine, 5); }

TEST(CoatNormals, a_mirror_coat_reflects_alike_however_the_base_leans) {
  for (const LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf})
    for (const double tilt : {-60.0, -37.0, 37.0, 60.0}) {
      auto [scene, settings] = floor_of(coated(0, 0), 60, 256);
      scene.materials[0].normal_texture = add_leaning_map(scene, tilt);
      settings.environment.radiance = glm::vec3(1);
      settings.light_sampling = sampling;
      const MeanAndError seen = mean_of(film_of(scene, settings));
      EXPECT_NEAR(seen.mean, coat_reflectance(0.5), 4 * seen.sigma + 1e-4) << tilt << " degrees";
    }
}

TEST(CoatNormals, a_mirror_coat_of_a_leaning_map_loses_nothing_to_the_terminator) {
  for (const double tilt : {10.0, 25.0}) {  // away from the view, so that what it reflects leaves near the horizon
    auto [scene, settings] = floor_of(coated(0, 0), 30, 256);
    scene.materials[0].clearcoat_normal_texture = add_leaning_map(scene, -tilt);
    settings.environment.radiance = glm::vec3(1);
    const MeanAndError seen = mean_of(film_of(scene, settings));
    EXPECT_NEAR(seen.mean, coat_reflectance(std::cos((30 + tilt) * kPi / 180)), 4 * seen.sigma + 3e-4) << tilt;
  }
}

/// Radiance towards the normal of a rough coat under a distant light of irradiance 1 across its
/// rays. [Walter et al. 2007]
double rough_coat_radiance(double alpha, double light_deg) {
  const double a2 = alpha * alpha, cos_i = std::cos(light_deg * kPi / 180), cos_h = std::cos(light_deg * kPi / 360);
  const double t = cos_h * cos_h * (a2 - 1) + 1, d = a2 / (kPi * t * t);
  const double length_i = std::sqrt(a2 * (1 - cos_i * cos_i) + cos_i * cos_i);
  return coat_reflectance(1) * d * 2 / (1 + length_i / cos_i) / 4;
}

TEST(CoatNormals, a_rough_coat_under_a_distant_light_has_its_radiance_however_the_base_leans) {
  for (const double tilt : {0.0, 53.0, -53.0})  // to the light, and so far from it that the base is dark
    for (const double light_deg : {20.0, 50.0, 75.0}) {
      auto [scene, settings] = floor_of(coated(0, 0.6F), 0, 16);
      scene.materials[0].normal_texture = add_leaning_map(scene, tilt);
      PunctualLight sun;
      sun.kind = LightKind::directional;
      sun.intensity = glm::vec3(1);
      sun.direction = {-std::sin(light_deg * kPi / 180), -std::cos(light_deg * kPi / 180), 0};
      scene.lights = {sun};
      const double expected = rough_coat_radiance(0.36, light_deg);
      EXPECT_NEAR(mean_of(film_of(scene, settings)).mean, expected, 2e-3 * expected) << tilt << ", " << light_deg;
    }
}

// The base leans away from one lamp and from the part of the sky that the coat shows.
TEST(CoatNormals, every_way_to_find_light_agrees_on_a_coat_over_another_normal) {
  const auto found_by = [](LightSampling sampling, float transmission) {
    Material material = coated(0.1F, 0.5F);
    material.sheen_color = glm::vec3(0.3F);
    material.sheen_roughness = 0.5F;
    material.roughness = 0.4F;
    material.transmission = transmission;
    if (transmission > 0) material.specular = 1;
    auto [scene, settings] = floor_of(material, -30, 8192);
    scene.materials[0].normal_texture = add_leaning_map(scene, -53);
    scene.materials[0].clearcoat_normal_texture = add_leaning_map(scene, 15);
    for (const float side : {-1.0F, 1.0F}) {
      Primitive lamp;
      add_quad(lamp, {2 * side, 0.5F, side}, {0, 1, 0}, {0, 0, -2 * side});
      add_mesh(scene, "lamp", std::move(lamp), lambert(0, 3));
      scene.materials.back().double_sided = true;
    }
    settings.environment.radiance = glm::vec3(0.4F);
    settings.light_sampling = sampling;
    settings.max_depth = 2;
    return mean_of(film_of(scene, settings));
  };
  for (const float transmission : {0.0F, 0.5F}) {
    const MeanAndError both = found_by(LightSampling::mis, transmission);
    for (const LightSampling sampling : {LightSampling::light, LightSampling::bsdf}) {
      const MeanAndError one = found_by(sampling, transmission);
      EXPECT_NEAR(one.mean, both.mean, 4 * std::hypot(one.sigma, both.sigma)) << "transmission " << transmission;
      EXPECT_LT(one.sigma, 0.01 * one.mean);
    }
  }
}

TEST(CoatNormals, every_device_renders_the_same_coat_over_another_normal) {
  const auto bits = [](std::uint32_t lanes, bool chunked) {
    auto [scene, settings] = floor_of(coated(0.5F, 0.5F), 30, 64);
    scene.materials[0].normal_texture = add_leaning_map(scene, -53);
    settings.environment.radiance = glm::vec3(1);
    Execution execution;
    execution.lanes = lanes;
    execution.chunked = chunked;
    return mean_of(film_of(scene, settings, execution)).mean;
  };
  const double wide = bits(16, true);
  EXPECT_EQ(bits(8, true), wide);
  EXPECT_EQ(bits(1, true), wide);
  EXPECT_EQ(bits(1, false), wide);
}

}  // namespace
}  // namespace eikon::test
