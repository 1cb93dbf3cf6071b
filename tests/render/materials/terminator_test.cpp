// SPDX-License-Identifier: Apache-2.0
// The terminator of shading normals is hidden on what a surface scatters widely, and not on its
// mirror images (kernels/bsdf/terminator.h).
#include "render/materials/leaning_floor.h"

namespace eikon::test {
namespace {

double radians(double degrees) { return degrees * kPi / 180; }

/// The angle, in radians, by which a map of 8 bits leans that is asked for this one.
double lean_in_map(double lean_deg) {
  const auto byte = [](double x) { return std::round(127.5 + 127.5 * x) - 127.5; };
  return std::atan2(byte(std::sin(radians(lean_deg))), byte(std::cos(radians(lean_deg))));
}

/// [Chiang, Li, Burley 2019, equation 3]
double terminator_factor(double light, double lean) {
  const double g = std::min(std::cos(light) / (std::cos(light - lean) * std::cos(lean)), 1.0);
  return ((g - g * g) + 1) * g;
}

/// A dielectric of index 1.5 over a base.
Material plastic(float albedo, float roughness) {
  Material material = lambert(albedo);
  material.specular = 1;
  material.roughness = roughness;
  return material;
}

/// Radiance of a floor under a sun of irradiance 1 across its rays. view, light: angles with the
/// floor's normal, towards +x, radians.
double radiance(const Material& material, double view, double light, double lean_deg) {
  auto [scene, settings] = floor_of(material, view * 180 / kPi, 16);
  if (lean_deg != 0) {
    const Texture leaning = add_leaning_map(scene, lean_deg);
    scene.materials[0].normal_texture = leaning;
    if (material.clearcoat > 0) scene.materials[0].clearcoat_normal_texture = leaning;
  }
  PunctualLight sun;
  sun.kind = LightKind::directional;
  sun.intensity = glm::vec3(1);
  sun.direction = {-std::sin(light), -std::cos(light), 0};
  scene.lights = {sun};
  return mean_of(film_of(scene, settings)).mean;
}

/// The radiance of a floor that a map leans, over that of a flat one with the same angles between
/// its normal, the view and the sun.
double kept(const Material& material, double light_deg, double lean_deg) {
  const double view = radians(10), light = radians(light_deg), lean = lean_in_map(lean_deg);
  return radiance(material, view, light, lean_deg) / radiance(material, view - lean, light - lean, 0);
}

constexpr double kLeanDeg =
    30;  // towards the sun: where that is 75 degrees low, the fade takes half of a diffuse surface's light

TEST(Terminator, fades_highlights_as_far_as_they_are_wide) {
  for (const double light_deg : {30.0, 60.0, 75.0})
    for (const float roughness : {0.3F, 0.6F, 1.0F}) {
      const double alpha = double(roughness) * double(roughness);
      const double fade = terminator_factor(radians(light_deg), lean_in_map(kLeanDeg)),
                   expected = 1 - alpha + alpha * fade;
      Material metal = plastic(0.7F, roughness), coat = lambert(0);
      metal.metallic = 1;
      coat.clearcoat = 1;
      coat.clearcoat_roughness = roughness;
      EXPECT_NEAR(kept(plastic(0, roughness), light_deg, kLeanDeg), expected, 0.01)
          << "plastic, " << light_deg << ", " << roughness;
      EXPECT_NEAR(kept(metal, light_deg, kLeanDeg), expected, 0.01) << "metal, " << light_deg << ", " << roughness;
      EXPECT_NEAR(kept(coat, light_deg, kLeanDeg), expected, 0.01) << "coat, " << light_deg << ", " << roughness;
    }
}

TEST(Terminator, fades_all_of_a_diffuse_base) {
  for (const double light_deg : {30.0, 60.0, 75.0}) {
    const double fade = terminator_factor(radians(light_deg), lean_in_map(kLeanDeg));
    EXPECT_NEAR(kept(lambert(0.5F), light_deg, kLeanDeg), fade, 0.01) << "Lambert, " << light_deg;
    // The highlight is so narrow that it does not reach the camera, and the base is all that is
    // seen.
    EXPECT_NEAR(kept(plastic(0.5F, 0.1F), light_deg, kLeanDeg), fade, 0.01) << "plastic, " << light_deg;
  }
}

// The sky is white, so a mirror shows its reflectance at the angle of view with its own normal.
TEST(Terminator, leaves_mirror_images_whole) {
  Material metal = plastic(1, 0), coat = lambert(0);
  metal.metallic = 1;
  coat.clearcoat = 1;
  for (const double lean_deg :
       {0.0, -10.0, -25.0})  // away from the view, so that what it reflects leaves near the horizon
    for (const Material& material : {plastic(0, 0), metal, coat}) {
      auto [scene, settings] = floor_of(material, 30, 256);
      scene.materials[0].normal_texture = scene.materials[0].clearcoat_normal_texture =
          add_leaning_map(scene, lean_deg);
      settings.environment.radiance = glm::vec3(1);
      const MeanAndError seen = mean_of(film_of(scene, settings));
      const double cosine = std::cos(radians(30) - lean_in_map(lean_deg));
      const double expected = material.metallic > 0 ? 1 : 0.04 + 0.96 * std::pow(1 - cosine, 5);
      EXPECT_NEAR(seen.mean, expected, 4 * seen.sigma + 1e-3 * expected)
          << lean_deg << " degrees, coat " << material.clearcoat;
    }
}

}  // namespace
}  // namespace eikon::test
