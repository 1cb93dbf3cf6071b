// SPDX-License-Identifier: Apache-2.0
// Light paths that are aimed by what a trial has learned: the mean stays whatever the tables say,
// and the bits are those of every way.
#include <random>

#include "guide/light_aim.h"
#include "render/lights/light_path_scenes.h"
#include "render/pilot/pilot.h"

namespace eikon::test {
namespace {

/// A closed room with a lamp, a small glass ball, and a large pane before a black wall: nothing
/// that the lamp sends through the pane comes back.
std::pair<Scene, Settings> ball_and_pane(std::uint32_t side, std::uint64_t spp) {
  Scene scene;
  Primitive walls, lamp, pane, black;
  add_box(walls, {-1, -1, -1}, {1, 1, 1.5F}, true);
  add_quad(lamp, {-0.2F, 0.97F, -0.2F}, {0.4F, 0, 0}, {0, 0, 0.4F});
  add_box(pane, {-0.95F, -0.5F, -0.5F}, {-0.9F, 0.5F, 0.5F}, false);
  add_quad(black, {-0.98F, -0.6F, -0.6F}, {0, 1.2F, 0}, {0, 0, 1.2F});
  add_mesh(scene, "walls", std::move(walls), lambert({0.6F, 0.5F, 0.4F}));
  add_mesh(scene, "lamp", std::move(lamp), lambert(0.3F, 20));
  add_mesh(scene, "pane", std::move(pane), glass(1.5F, 0, true));
  add_mesh(scene, "black", std::move(black), lambert(0.0F));
  add_mesh(scene, "ball", sphere({0.2F, -0.7F, 0.2F}, 0.25F, 10, false, true), glass(1.5F, 0, true));
  return {std::move(scene), seen_from_above(side, spp)};
}

std::shared_ptr<const LightAim> wrong_aim(std::size_t targets, unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&] { return double(random() >> 8) * 0x1p-24; };
  std::vector<AimedTarget> aimed(kAimKinds * targets);
  for (AimedTarget& target : aimed) {
    target.weight = 0.25 + 2 * number();
    for (double& bin : target.bins) bin = number() < 0.5 ? 0 : number();
  }
  return std::make_shared<const LightAim>(make_light_aim(aimed, {0.5F, 8}));
}

TEST(LightAimRender, any_table_leaves_the_mean) {
  auto [room, in_room] = room_of_glass(24, 512);
  auto [floor, in_sun] = floor_in_the_sun(16, 32768, 300);
  auto [bulb, by_bulb] = room_of_glass(24, 512);
  bulb.materials[1].emission = glm::vec3(0);
  bulb.lights = {small_lamp({0, 0.8, 0}, 0.4F), sunshine({0.3, -1, 0.1}, 0.3F)};
  struct Case {
    const char* name;
    const Scene& scene;
    Settings settings;
  };
  for (const Case& given :
       {Case{"a lamp", room, in_room}, Case{"a map", floor, in_sun}, Case{"without extent", bulb, by_bulb}}) {
    Settings settings = with_light_paths(given.settings, 1);
    settings.max_depth = 8;
    const Film even = film_of(given.scene, settings);
    settings.seed = 3;
    const Features features(given.scene, settings);
    settings.light_aim = wrong_aim(pack_scene(given.scene, features, settings).light_targets.size(), 7);
    const Film aimed = film_of(given.scene, settings);
    EXPECT_FALSE(same_film(even, aimed));
    for (std::uint32_t q = 0; q < 4; ++q)
      for (std::uint32_t c = 0; c < 3; ++c)
        EXPECT_TRUE(
            agree(mean_of(aimed, c, quarter(aimed.layout(), q)), mean_of(even, c, quarter(even.layout(), q)), 36))
            << given.name << ", quarter " << q << ", channel " << c;
  }
}

TEST(LightAimRender, has_the_same_bits_by_every_way_of_tracing) {
  auto [scene, settings] = room_of_glass(20, 4);
  settings = with_light_paths(settings, 0.3);
  const Features features(scene, settings);
  settings.light_aim = wrong_aim(pack_scene(scene, features, settings).light_targets.size(), 5);
  expect_the_same_bits_by_every_way(scene, settings, film_of(scene, settings));
}

Settings with_trial_of(Settings settings, std::uint64_t paths) {
  settings = with_light_paths(settings, 1.0 / 16);
  settings.light_trial_paths = paths;
  return settings;
}

TEST(LightAimRender, a_trial_aims_past_a_pane_that_leads_nowhere) {
  const auto [scene, settings] = ball_and_pane(32, 64);
  const RenderOutput aimed = output_of(scene, with_trial_of(settings, 1U << 18));
  EXPECT_GT(aimed.report.pilot.light_aim_gain, 1.02);
  ASSERT_GT(aimed.report.pilot.light_path_count, 0U);
  Settings even = settings;
  even.light_path_count = aimed.report.pilot.light_path_count;
  const Film without = film_of(scene, even);
  EXPECT_FALSE(same_film(aimed.film, without));
  EXPECT_LT(aimed.film.predicted_error().relmse, without.predicted_error().relmse);
}

TEST(LightAimRender, a_trial_without_a_target_or_a_light_that_shines_has_nothing_to_learn) {
  auto [dark, settings] = room_of_glass(24, 2);
  dark.materials[1].emission = glm::vec3(0);
  dark.lights = {small_lamp({0, 0.8, 0}, 0)};
  Scene bare = closed_room_with_lamp();
  bare.materials.push_back(glass(1.5F, 0, true));  // nothing is made of it
  for (const Scene* scene : {&dark, &bare}) {
    const RenderOutput output = output_of(*scene, with_trial_of(settings, 1U << 14));
    EXPECT_EQ(output.report.pilot.light_aim_gain, 0);
    EXPECT_EQ(output.sample_set.sample_count(), 24U * 24 * 2);
  }
}

TEST(LightAimRender, a_trial_learns_the_same_by_every_way_and_for_each_part) {
  const auto [scene, usual] = ball_and_pane(24, 3);
  const Settings settings = with_trial_of(usual, 1U << 16);
  const RenderOutput expected = output_of(scene, settings);
  ASSERT_GT(expected.report.pilot.light_aim_gain, 0);
  Execution unfused;
  unfused.fused = false;
  Execution queues;
  queues.lanes = 1, queues.chunked = false, queues.layout = "bvh2";
  Execution small;
  small.unit_paths = 1024;
  for (const Execution& way : {Execution{}, small, unfused, queues}) {
    const RenderOutput output = output_of(scene, settings, way);
    EXPECT_EQ(output.report.pilot.light_aim_gain, expected.report.pilot.light_aim_gain);
    EXPECT_TRUE(same_film(output.film, expected.film));
  }
  Film by_samples(expected.film.layout());
  for (std::uint64_t sample = 0; sample < 3; ++sample) {
    Settings part = settings;
    part.sample_begin = sample, part.sample_end = sample + 1;
    by_samples.add(film_of(scene, part));
  }
  EXPECT_TRUE(same_film(by_samples, expected.film));
  Film by_windows(expected.film.layout());
  for (const Crop& window : {Crop{0, 0, 24, 9}, Crop{0, 9, 24, 24}}) {
    Settings part = settings;
    part.crop = window;
    by_windows.add(film_of(scene, part));
  }
  EXPECT_TRUE(same_film(by_windows, expected.film));
}

}  // namespace
}  // namespace eikon::test
