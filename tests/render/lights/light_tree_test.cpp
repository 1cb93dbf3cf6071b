// SPDX-License-Identifier: Apache-2.0
// Pictures of many lights: choosing them by a tree changes noise alone.
#include "pack/features.h"
#include "pack/pack.h"
#include "render/scene_builder.h"
#include "render/ways_to_shade.h"

namespace eikon::test {
namespace {

double uniform(std::uint32_t& state) {  // the same on every machine
  state = state * 1664525U + 1013904223U;
  return double(state >> 8) / 16777216.0;
}

/// A box of side 2, open to the front, with small lamps in it that face anywhere, some to both
/// sides, over three decades of power.
std::pair<Scene, Settings> lamp_room(int lamps, std::uint32_t side, std::uint64_t spp) {
  Scene scene;
  Primitive walls, one, both, ball = sphere({0.2F, -0.5F, 0.1F}, 0.4F, 8, false);
  add_quad(walls, {-1, -1, 1}, {2, 0, 0}, {0, 0, -2});
  add_quad(walls, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
  add_quad(walls, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
  add_quad(walls, {-1, -1, 1}, {0, 0, -2}, {0, 2, 0});
  std::uint32_t state = 7;
  const auto coordinate = [&] { return float(1.6 * uniform(state) - 0.8); };
  for (int i = 0; i < lamps; ++i) {
    const glm::vec3 p(coordinate(), coordinate(), coordinate());
    const float size = 0.04F * std::pow(10.0F, coordinate());
    add_triangle(i % 3 == 0 ? both : one, p, p + size * glm::vec3(coordinate(), coordinate(), coordinate()),
                 p + size * glm::vec3(coordinate(), coordinate(), coordinate()));
  }
  add_mesh(scene, "walls", std::move(walls), lambert({0.7F, 0.5F, 0.3F}));
  add_mesh(scene, "ball", std::move(ball), lambert(0.6F));
  add_mesh(scene, "lamps", std::move(one), lambert(0, 400));
  Material double_sided = lambert(0, 150);
  double_sided.double_sided = true;
  add_mesh(scene, "panes", std::move(both), double_sided);
  Settings settings = settings_for(side, side, spp);
  settings.camera = look_at_camera({0.3, 0.1, 3.2}, {0, -0.1, 0}, {0, 1, 0}, 0.7);
  settings.environment.radiance = glm::vec3(0.02F);
  return {std::move(scene), settings};
}

TEST(LightTree, lights_alone_and_scattered_rays_alone_and_both_give_one_mean) {
  auto [scene, settings] = lamp_room(90, 24, 1024);
  ASSERT_TRUE(Features(scene, settings).has(Feature::light_tree));
  std::vector<MeanAndError> found;
  for (const LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    settings.light_sampling = sampling;
    settings.seed += 1;
    settings.max_depth = 4;
    settings.sample_end = sampling == LightSampling::bsdf ? 16384 : 1024;
    found.push_back(mean_of(film_of(scene, settings)));
  }
  EXPECT_TRUE(agree(found[0], found[1], 3));
  EXPECT_TRUE(agree(found[0], found[2], 3));
  EXPECT_TRUE(agree(found[1], found[2], 3));
}

// With lamps alone there is nothing beside the tree to choose; with punctual lights it holds kinds
// that no ray can meet.
TEST(LightTree, direct_light_of_all_is_the_sum_of_what_each_gives_alone) {
  Scene scene;
  Primitive floor;
  add_quad(floor, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  add_mesh(scene, "floor", std::move(floor), lambert(0.5F));
  Settings settings = settings_for(16, 16, 256);
  settings.camera = look_at_camera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 0.8);
  settings.max_depth = 2;
  std::uint32_t state = 3;
  std::vector<PunctualLight> lights;
  for (int i = 0; i < 24; ++i) {
    PunctualLight light;
    light.kind = i % 8 == 7 ? LightKind::directional : i % 2 == 0 ? LightKind::spot : LightKind::point;
    light.position = {2 * uniform(state) - 1, 0.05 + uniform(state), 2 * uniform(state) - 1};
    light.direction = glm::normalize(glm::dvec3(uniform(state) - 0.5, -1, uniform(state) - 0.5));
    light.outer_cone_rad = 0.3 + uniform(state);
    light.intensity = glm::vec3(float(std::pow(10.0, 3 * uniform(state) - 2)));
    if (light.kind == LightKind::directional) light.intensity *= 0.01F;
    lights.push_back(light);
  }
  double sum = 0, variance = 0;
  for (const PunctualLight& light : lights) {
    scene.lights = {light};
    const MeanAndError alone = mean_of(film_of(scene, settings));
    sum += alone.mean;
    variance += alone.sigma * alone.sigma;
  }
  scene.lights = lights;
  settings.sample_end = 4096;
  settings.seed = 5;
  ASSERT_TRUE(Features(scene, settings).has(Feature::light_tree));
  EXPECT_TRUE(agree(mean_of(film_of(scene, settings)), {sum, std::sqrt(variance)}, 1));
}

TEST(LightTree, N6_a_film_has_the_same_bits_however_it_is_traced) {
  auto [scene, settings] = lamp_room(300, 19, 6);
  const Film once = film_of(scene, settings);
  for (const Execution& execution : ways_to_shade())
    ASSERT_TRUE(same_film(once, film_of(scene, settings, execution))) << describe(execution);
}

TEST(LightTree, is_for_more_than_a_few_lights_that_have_a_place) {
  auto [scene, settings] = lamp_room(3, 8, 1);
  EXPECT_FALSE(Features(scene, settings).has(Feature::light_tree)) << "three lamps and a sky";
  scene = lamp_room(4, 8, 1).first;
  const Features features(scene, settings);
  EXPECT_TRUE(features.has(Feature::light_tree));
  const PackedScene packed = pack_scene(scene, features, settings);
  EXPECT_EQ(packed.tree_light_count, 4U);
  EXPECT_EQ(packed.light_nodes.size(), 3U);
  EXPECT_EQ(packed.light_alias_table.size(), 2U) << "the tree, and the sky";
  double sum = 0;
  for (const PackedLight& light : packed.light_summary) sum += light.probability;
  EXPECT_NEAR(sum, 1, 1e-9);
}

// A needle is no light that can be sampled, so fewer may be left than the tree was meant for, even
// none.
TEST(LightTree, lamps_that_cannot_be_sampled_leave_a_tree_of_fewer_lights_or_of_none) {
  for (const int good : {0, 1, 2}) {
    Scene scene;
    Primitive floor, lamps;
    add_quad(floor, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
    for (int i = 0; i < 6; ++i) {
      const float x = 0.3F * float(i);  // as wide as the floor: small lamps need no tree
      if (i < good)
        add_triangle(lamps, {x, 1, 0}, {x + 0.05F, 1, 0}, {x, 1, 0.05F});
      else
        add_triangle(lamps, {x, 1, 0}, {x + 0.1F, 1, 0}, {x + 0.05F, 1, 0});  // without area
    }
    add_mesh(scene, "floor", std::move(floor), lambert(0.5F));
    add_mesh(scene, "lamps", std::move(lamps), lambert(0, 10));
    Settings settings = settings_for(8, 8, 64);
    settings.camera = look_at_camera({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}, 0.3);
    settings.environment.radiance = glm::vec3(0.1F);
    ASSERT_TRUE(Features(scene, settings).has(Feature::light_tree));
    const MeanAndError all = mean_of(film_of(scene, settings));
    settings.light_sampling = LightSampling::bsdf;
    settings.sample_end = 4096;
    settings.seed = 2;
    EXPECT_TRUE(agree(all, mean_of(film_of(scene, settings)), 3)) << good;
  }
}

}  // namespace
}  // namespace eikon::test
