// SPDX-License-Identifier: Apache-2.0
// The number of light paths that a pilot chooses: its prediction holds, and it is the same by any
// way and for any part.
#include <cmath>

#include "render/lights/light_path_scenes.h"
#include "render/pilot/pilot.h"

namespace eikon::test {
namespace {

/// Settings that leave the number of light paths to a trial.
Settings with_trial(Settings settings, std::uint64_t paths = 1U << 14) {
  settings = with_light_paths(settings, 1.0 / 16);
  settings.light_trial_paths = paths;
  return settings;
}

std::uint64_t rays_of(const RenderOutput& output) { return output.report.rays.total(); }

TEST(LightPathTrial, predicts_what_light_paths_gain) {
  auto [scene, settings] = room_of_glass(48, 256);
  // Sums over seeds, as fireflies make up much of the error of one without light paths.
  double error_with = 0, error_without = 0, rays_with = 0, rays_without = 0, predicted = 0;
  for (settings.seed = 0; settings.seed < 8; ++settings.seed) {
    const RenderOutput with = output_of(scene, with_trial(settings, 1U << 16)), without = output_of(scene, settings);
    ASSERT_GT(with.report.pilot.light_path_count, 0U);
    error_with += with.film.predicted_error().relmse, rays_with += double(rays_of(with));
    error_without += without.film.predicted_error().relmse, rays_without += double(rays_of(without));
    predicted = with.report.pilot.light_path_gain;
  }
  const double gain = error_without * rays_without / (error_with * rays_with);
  EXPECT_GT(gain, 1.4);
  EXPECT_LT(std::abs(std::log(predicted / gain)), std::log(1.6)) << predicted << " predicted, and " << gain << " found";
}

TEST(LightPathTrial, decides_the_same_by_every_way_and_for_each_part) {
  const auto [scene, usual] = room_of_glass(24, 5);
  const Settings settings = with_trial(usual);
  const RenderOutput expected = output_of(scene, settings);
  Execution small;
  small.unit_paths = 1024;
  Execution unfused;
  unfused.fused = false;
  Execution queues;
  queues.lanes = 1, queues.chunked = false, queues.layout = "bvh2";
  // The same way stands there more than once, since threads store splats in another order each
  // time.
  for (const Execution& way : {Execution{}, Execution{}, Execution{}, small, small, unfused, queues}) {
    const RenderOutput output = output_of(scene, settings, way);
    EXPECT_EQ(output.report.pilot.light_path_count, expected.report.pilot.light_path_count);
    EXPECT_EQ(output.report.pilot.light_path_gain, expected.report.pilot.light_path_gain);
    EXPECT_TRUE(same_film(output.film, expected.film));
  }
  Settings part = settings;
  part.crop = {3, 4, 20, 11};
  part.sample_begin = 2, part.sample_end = 3;
  EXPECT_EQ(output_of(scene, part).report.pilot.light_path_count, expected.report.pilot.light_path_count);
  // A given number makes the same image.
  Settings given = usual;
  given.light_path_count = expected.report.pilot.light_path_count;
  EXPECT_TRUE(same_film(film_of(scene, given), expected.film));
}

TEST(LightPathTrial, without_light_paths_an_image_has_the_bits_of_one_that_never_had_any) {
  auto [scene, settings] = room_of_glass(24, 5);
  Primitive ceiling;  // which camera paths hit often, so that light paths bring next to nothing
  add_quad(ceiling, {-0.98F, 0.98F, -0.98F}, {1.96F, 0, 0}, {0, 0, 2.4F});
  add_mesh(scene, "ceiling", std::move(ceiling), lambert(0.3F, 5));
  const RenderOutput output = output_of(scene, with_trial(settings));
  EXPECT_GT(output.report.pilot.light_trial_paths, 0U);
  ASSERT_EQ(output.report.pilot.light_path_count, 0U);
  const Film plain = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 24; ++y)
    for (std::uint32_t x = 0; x < 24; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) {
        ASSERT_TRUE(output.film.total(x, y, c) == plain.total(x, y, c)) << x << ' ' << y;
        ASSERT_EQ(output.film.mean(x, y, c), plain.mean(x, y, c)) << x << ' ' << y;
      }
}

TEST(LightPathTrial, lights_that_only_light_paths_find_always_have_some) {
  auto [scene, settings] = room_of_glass(24, 2);
  for (Material& material : scene.materials) material.emission = {0, 0, 0};
  PunctualLight bulb;
  bulb.position = {0, 0.5, 0.5};
  bulb.intensity = {1, 1, 1};
  scene.lights.push_back(bulb);
  // A view of a corner, which is hardly lit by them.
  settings.camera = look_at_camera({0.8, 0.8, 1.3}, {1, 1, 1.5}, {0, 1, 0}, 0.01);
  EXPECT_GT(output_of(scene, with_trial(settings)).report.pilot.light_path_count, 0U);
}

TEST(LightPathTrial, there_is_one_for_pictures_that_are_large_enough) {
  Settings settings = settings_for(1280, 720, 64);
  EXPECT_EQ(usual_light_trial_paths(settings, false), 1U << 16);
  settings.sample_begin = 7, settings.sample_end = 8;
  EXPECT_EQ(usual_light_trial_paths(settings, false), 1U << 16);
  settings.width = settings.height = 128;
  EXPECT_EQ(usual_light_trial_paths(settings, false), 1U << 14);
  settings.width = 127;
  EXPECT_EQ(usual_light_trial_paths(settings, false), 0U);
  EXPECT_EQ(usual_light_trial_paths(settings, true), 1U << 14) << "nothing else finds some of the light";
}

}  // namespace
}  // namespace eikon::test
