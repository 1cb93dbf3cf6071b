// SPDX-License-Identifier: Apache-2.0
// Boundaries between solids that do not show are no events: no edge ends there, and no partial sum
// counts them.
#include "render/materials/glass_builder.h"

namespace eikon::test {
namespace {

const Material kRankedWater = ranked(glass(1.333F, 0, true), 1);
/// Lower than the water: inside of it nothing of them shows, however rough, coloured or dispersive
/// they are.
const Material kUnseen = [] {
  Material m = ranked(glass(1.7F, 0.4F, true), 0);
  m.base_color = {0.5F, 0.7F, 0.2F};
  m.dispersion = 1;
  m.transmission = 0.5F;
  return m;
}();

/// Unseen slabs and a ball across each other, between everything and everything.
void add_unseen(Scene& scene) {
  add_block(scene, "slab", {-0.9F, -0.9F, 0.25F}, {0.9F, 0.9F, 0.45F}, kUnseen);
  add_block(scene, "beam", {-0.8F, -0.3F, -0.8F}, {0.1F, -0.1F, 0.8F}, kUnseen);
  add_block(scene, "plank", {-0.4F, -0.2F, -0.7F}, {0.7F, 0.2F, -0.5F}, kUnseen);
  add_mesh(scene, "ball", sphere({0.3F, 0.2F, 0.1F}, 0.4F, 12, false), kUnseen);
}

/// A furnace in water, of walls that emit 1 and reflect half; the camera is inside.
std::pair<Scene, Settings> furnace_in_water(bool with_unseen) {
  Scene scene;
  add_block(scene, "water", {-3, -3, -3}, {3, 3, 3}, kRankedWater);
  Primitive walls;
  add_box(walls, {-1, -1, -1}, {1, 1, 1}, true);
  add_mesh(scene, "walls", std::move(walls), lambert(0.5F, 1));
  if (with_unseen) add_unseen(scene);
  Settings settings = settings_for(12, 12, 16);
  settings.camera = look_at_camera({0.1, 0.05, 0.9}, {0, 0, 0}, {0, 1, 0}, 1.2);
  settings.light_sampling = LightSampling::bsdf;
  settings.roulette_depth = 1000;
  settings.max_depth = 9;
  return {std::move(scene), settings};
}

// Every path carries 1, 1/2, 1/4, ... whatever its random numbers: with and without boundaries the
// sums have the same bits.
TEST(HiddenBoundaries, L10_the_partial_sums_of_a_furnace_have_the_same_bits_with_and_without_them) {
  auto [bare, settings] = furnace_in_water(false);
  auto [full, unused] = furnace_in_water(true);
  settings.depth_series = {0, 1, 2, 5};
  for (const std::uint32_t edges : {1U, 2U, 4U, 9U}) {
    settings.max_depth = edges;
    const Film film = film_of(full, settings);
    EXPECT_TRUE(same_film(film, film_of(bare, settings))) << edges << " edges";
    for (std::uint32_t y = 0; y < 12; ++y)
      for (std::uint32_t x = 0; x < 12; ++x) ASSERT_EQ(film.mean(x, y, 0), 2 - std::pow(0.5, edges - 1)) << edges;
  }
  Execution queued;  // as GPUs trace
  queued.lanes = 1;
  queued.chunked = false;
  EXPECT_TRUE(same_film(film_of(full, settings, queued), film_of(full, settings)));
}

enum class Unseen { none, everywhere, before_the_camera };

/// A floor in water with a wall, a mirror and a lamp above.
std::pair<Scene, Settings> room_in_water(Unseen unseen) {
  Scene scene;
  add_block(scene, "water", {-3, -3, -3}, {3, 3, 3}, kRankedWater);
  Primitive floor, mirror, lamp;
  add_quad(floor, {-1, -0.9F, 0.5F}, {2, 0, 0}, {0, 0, -1.5F});
  add_quad(floor, {0.95F, -0.9F, 0.5F}, {0, 0, -1.5F}, {0, 1.5F, 0});
  add_quad(mirror, {-0.9F, -0.85F, -0.95F}, {1.2F, 0, 0}, {0, 1.4F, 0.3F});
  add_quad(lamp, {-0.3F, 0.9F, -0.3F}, {0.6F, 0, 0}, {0, 0, 0.6F});
  Material polished = lambert(0.9F);
  polished.metallic = 1;
  polished.roughness = 0;
  add_mesh(scene, "floor", std::move(floor), lambert({0.7F, 0.5F, 0.3F}));
  add_mesh(scene, "mirror", std::move(mirror), polished);
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 20));
  if (unseen == Unseen::everywhere) add_unseen(scene);
  // No shadow ray meets this one, which it would end at as at glass.
  if (unseen == Unseen::before_the_camera) add_block(scene, "slab", {-0.9F, -0.8F, 0.6F}, {0.8F, 0.9F, 0.7F}, kUnseen);
  Settings settings = settings_for(16, 16, 256);
  settings.camera = look_at_camera({0.1, 0.05, 0.9}, {0, -0.2, 0}, {0, 1, 0}, 1.2);
  return {std::move(scene), settings};
}

void expect_same_means(const Film& without, const Film& with, const std::string& what, int tests) {
  const auto channels = std::uint32_t(with.layout().channels.size());
  for (std::uint32_t channel = 0; channel < channels; ++channel) {
    const MeanAndError a = mean_of(without, channel), b = mean_of(with, channel);
    EXPECT_LE(std::abs(a.mean - b.mean),
              z_bound(tests * int(channels)) * std::hypot(a.sigma, b.sigma) + kRounding * a.mean)
        << what << ", channel " << with.layout().channels[channel];
  }
  EXPECT_GT(mean_of(with).mean, 0.05) << what;
  EXPECT_LT(mean_of(with).sigma, 0.03 * mean_of(with).mean) << what << ": more samples";
}

TEST(HiddenBoundaries, every_partial_sum_of_paths_and_direct_light_have_the_same_mean_with_and_without_them) {
  auto [bare, settings] = room_in_water(Unseen::none);
  const Scene full = room_in_water(Unseen::everywhere).first;
  settings.depth_series = {0, 1, 2, 4};
  for (const std::uint32_t edges : {0U, 2U}) {
    settings.max_depth = edges;
    settings.seed = 1;
    const Film without = film_of(bare, settings);
    ASSERT_GE(without.layout().channels.size(), 18U);  // the picture, and five bins of the series
    settings.seed = 2;
    expect_same_means(without, film_of(full, settings), "edges " + std::to_string(edges), 2);
  }
}

TEST(HiddenBoundaries, whitted_and_cast_rays_see_through_them) {
  auto [bare, settings] = room_in_water(Unseen::none);
  const Scene full = room_in_water(Unseen::before_the_camera).first;
  for (const bool raycast : {false, true}) {
    settings.integrator = raycast ? Integrator::raycast : Integrator::whitted;
    if (raycast) settings.light_sampling = LightSampling::light, settings.max_depth = 2;
    settings.seed = 1;
    const Film without = film_of(bare, settings);
    settings.seed = 2;
    expect_same_means(without, film_of(full, settings), raycast ? "raycast" : "whitted", 2);
  }
}

}  // namespace
}  // namespace eikon::test
