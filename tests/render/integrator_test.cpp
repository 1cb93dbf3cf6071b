// SPDX-License-Identifier: Apache-2.0
// What else than a whole path tracer the settings make: against the path tracer, and closed forms.
#include "render/scene_builder.h"

namespace eikon::testing {
namespace {

Material polished(float metallic) {
  Material m;
  m.base_color = glm::vec3(0.9F);
  m.metallic = metallic;
  m.roughness = 0;
  return m;
}

Material clear_glass() {
  Material m = polished(0);
  m.transmission = 1;
  m.solid = true;
  return m;
}

/// A diffuse floor seen directly, in a mirror, and through a ball of glass, lit by a bulb that no ray can meet.
std::pair<Scene, Settings> still_life(float albedo) {
  Scene scene;
  Primitive floor, mirror;
  add_quad(floor, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8});
  add_quad(mirror, {-3, 0, -2}, {6, 0, 0}, {0, 3, -0.5F});
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
  add_mesh(scene, "mirror", std::move(mirror), polished(1));
  add_mesh(scene, "ball", sphere({0.6F, 0.7F, 0.3F}, 0.6F, 16, false, true), clear_glass());
  PunctualLight bulb;
  bulb.position = {-1, 3, 1};
  bulb.intensity = glm::vec3(10);
  scene.lights.push_back(bulb);
  Settings settings = settings_for(40, 30, 16);
  settings.camera = look_at_camera({0, 1.6, 4.5}, {0, 0.6, 0}, {0, 1, 0}, 0.7);
  settings.light_sampling = LightSampling::light;
  settings.max_depth = 24;
  settings.roulette_depth = 100;
  return {std::move(scene), settings};
}

TEST(Whitted, is_the_path_of_one_diffuse_vertex_seen_through_mirrors_and_glass) {
  // Light that met the floor k times has the factor albedo^k: of so dark a floor only k = 1 is left, and both integrators
  // follow the same rays there.
  constexpr float kDark = 0x1p-14F;
  auto [scene, settings] = still_life(kDark);
  const Film path = film_of(scene, settings);
  settings.whitted = true;
  const Film whitted = film_of(scene, settings);
  int lit = 0;
  for (std::uint32_t i = 0; i < 40 * 30; ++i) {
    const double expected = path.mean(i % 40, i / 40, 0), found = whitted.mean(i % 40, i / 40, 0);
    // Where only light is that met the floor twice, the path tracer sees kDark^2 of some radiance below 10.
    ASSERT_NEAR(found, expected, 2e-3 * expected + 10 * double(kDark) * double(kDark)) << i % 40 << ',' << i / 40;
    lit += found > 0 ? 1 : 0;
  }
  EXPECT_GT(lit, 500);  // the floor fills about half of the picture
}

TEST(Whitted, sees_nothing_twice_diffuse_and_glass_only_with_two_edges_more) {
  auto [scene, settings] = still_life(0.5F);
  settings.whitted = true;
  const auto mean_with = [&](std::uint32_t edges) {
    settings.max_depth = edges;
    return mean_of(film_of(scene, settings)).mean;
  };
  const double direct = mean_with(2), once = mean_with(3), twice = mean_with(4), often = mean_with(12);
  // The same random numbers: what is brighter is so by the edge that came in addition.
  EXPECT_GT(once, direct * 1.002);  // by the mirror
  EXPECT_GT(twice, once * 1.002);   // by the glass, which takes two refractions
  EXPECT_LT(often, twice * 1.05);
  settings.whitted = false;
  EXPECT_GT(mean_with(12), often * 1.001);  // the floor lights itself by the mirror
}

TEST(Roulette, of_one_probability_changes_no_mean) {
  for (const float survival : {0.9F, 0.75F}) {
    Settings settings = settings_for(24, 24, 256);
    settings.roulette = survival;
    settings.roulette_depth = 2;
    // Throughput is multiplied by .5^2 / survival in the mean square: the variance is bounded.
    EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.5F, 1), settings)), 2, 2)) << survival;
  }
}

TEST(Roulette, of_probability_one_is_none) {
  auto [scene, settings] = room(16, 16, 4);
  settings.max_depth = 6;
  settings.roulette_depth = 1000;
  const Film without = film_of(scene, settings);
  settings.roulette = 1;
  settings.roulette_depth = 2;
  EXPECT_TRUE(same_bits(without, film_of(scene, settings)));
}

}  // namespace
}  // namespace eikon::testing
