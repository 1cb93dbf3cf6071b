// SPDX-License-Identifier: Apache-2.0
// Pictures of materials by tables that were measured from known materials, beside those materials.
#include "render/measure.h"
#include "render/scene_builder.h"
#include "scene/measured_table.h"

namespace eikon::testing {
namespace {

Material by_table_of(const Material& known) {
  for (const DeviceInfo& info : list_devices()) {
    if (!info.unusable.empty()) continue;
    Device device(info);
    Scene scene;
    scene.materials = {known};
    Material measured;
    measured.metallic = measured.roughness = measured.specular = 0;
    measured.measured = std::make_shared<const MeasuredTable>(
        make_measured_table(measure(scene, 0, {0, 0}, device, info.platform.find("Oclgrind") == std::string::npos)));
    return measured;
  }
  throw std::runtime_error("no OpenCL device");
}

/// A ball under a white sky, which shows what it reflects of all light; or beside a lamp, on a floor.
std::pair<Scene, Settings> ball_of(const Material& material, bool lamp_lit) {
  Scene scene;
  if (lamp_lit) {
    Primitive floor, lamp;
    add_quad(floor, {-3, -1, 3}, {6, 0, 0}, {0, 0, -6});
    add_quad(lamp, {-1, 3, -1}, {1.5F, 0, 0}, {0, 0, 1.5F});
    add_mesh(scene, "floor", std::move(floor), lambert(0.4F));
    add_mesh(scene, "lamp", std::move(lamp), lambert(0, 12));
  }
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 24, false, true), material);
  Settings settings = settings_for(16, 16, 2048);
  settings.camera = look_at_camera({0, 0.8, 4}, {0, 0, 0}, {0, 1, 0}, 0.5);
  settings.environment.radiance = lamp_lit ? glm::vec3(0.1F, 0.12F, 0.16F) : glm::vec3(1);
  return {std::move(scene), settings};
}

// Radiance is linear in f. Under the sky each pixel is off by what bsdf_measured_test.cpp bounds for views from 2 degrees above it, |f - f'| over the
// cosine-weighted hemisphere: 1 % of f. The lamp is narrower: there f is off by up to
// 8 % in single directions (copper), and that a window's mean over the lamp and over the ball is within the same 1 % is found, not derived.
constexpr double kResolution = 0.01;

TEST(MeasuredPictures, are_those_of_the_measured_materials_within_the_tables_resolution) {
  Material copper, plastic;
  copper.roughness = 0.35F;
  copper.conductor = Conductor{{0.216561F, 0.958162F, 1.165808F}, {3.637741F, 2.577065F, 2.393857F}};
  plastic.base_color = {0.7F, 0.3F, 0.1F};
  plastic.metallic = 0;
  plastic.roughness = 0.4F;
  constexpr std::uint32_t kSide = 4;
  constexpr int kComparisons = 3 * 2 * 16 * 3;
  double worst = 0;
  for (const Material& known : {copper, plastic, lambert({0.8F, 0.5F, 0.2F})}) {
    const Material table = by_table_of(known);
    for (const bool lamp_lit : {false, true}) {
      const auto [analytic, settings] = ball_of(known, lamp_lit);
      const Film exact = film_of(analytic, settings), measured = film_of(ball_of(table, lamp_lit).first, settings);
      for (std::uint32_t y = 0; y < 16; y += kSide)
        for (std::uint32_t x = 0; x < 16; x += kSide)
          for (std::uint32_t c = 0; c < 3; ++c) {
            const Crop window{x, y, x + kSide, y + kSide};
            const MeanAndError a = mean_of(exact, c, window), b = mean_of(measured, c, window);
            worst = std::max(worst, std::abs(a.mean - b.mean) / a.mean);
            EXPECT_NEAR(b.mean, a.mean, z_bound(kComparisons) * std::hypot(a.sigma, b.sigma) + kResolution * a.mean)
                << (lamp_lit ? "lamp, " : "sky, ") << x << "," << y << " channel " << c;
            EXPECT_LT(std::hypot(a.sigma, b.sigma), 0.01 * a.mean) << "too few samples to tell";
          }
    }
  }
  std::printf("windows differ by %.2g at most, noise included\n", worst);
}

}  // namespace
}  // namespace eikon::testing
