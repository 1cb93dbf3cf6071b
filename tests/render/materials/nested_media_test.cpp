// SPDX-License-Identifier: Apache-2.0
// Solids inside, across and against each other, by priority, in scenes of known answer. Judged at
// significance 1 % per test.
#include <algorithm>
#include <functional>
#include <random>

#include "render/materials/glass_builder.h"

namespace eikon::test {
namespace {

void add_ball(Scene& scene, const char* name, glm::vec3 center, float radius, std::uint32_t rings, const Material& m) {
  add_mesh(scene, name, sphere(center, radius, rings, false), m);
}

/// The layer of a block across the z axis, far wider than any beam.
void add_layer(Scene& scene, const char* name, float z0, float z1, const Material& m) {
  add_block(scene, name, {-20, -20, z0}, {20, 20, z1}, m);
}

/// A tumbler: a block with a smaller one taken out of it.
void add_tumbler(Scene& scene, const Material& m) {
  Primitive wall;
  add_box(wall, {-1, -1, -1}, {1, 1, 1}, false);
  add_box(wall, {-0.75F, -0.75F, -0.75F}, {0.75F, 0.75F, 0.75F}, true);
  add_mesh(scene, "tumbler", std::move(wall), m);
}

void add_round(Scene& scene, const glm::dvec3& center, double radius, const Material& m) {
  Shape shape;
  shape.name = "round";
  shape.kind = ShapeKind::sphere;
  shape.size[0] = radius;
  shape.world_from_object = glm::translate(glm::dmat4(1), center);
  shape.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back(m);
  scene.shapes.push_back(shape);
}

Execution in_lanes(bool wide) {
  Execution execution;
  execution.lanes = wide ? 16 : 1;
  execution.chunked = wide;
  return execution;
}

struct Arrangement {
  const char* name;
  std::function<void(Scene&)> build;
};

const Material kWater = glass(1.333F, 0, true), kGlass = glass(1.5F, 0, true), kBubble = glass(1, 0, true),
               kIce = glass(1.31F, 0, true), kFlint = [] {
                 Material m = glass(1.62F, 0, true);
                 m.dispersion = 2;
                 return m;
               }();

std::vector<Arrangement> arrangements() {
  std::vector<Arrangement> all;
  all.push_back({"overlapping balls", [](Scene& scene) {
                   add_ball(scene, "water", {-0.4F, 0, 0}, 1, 24, ranked(kWater, 0));
                   add_ball(scene, "glass", {0.5F, 0.1F, 0}, 1, 20, ranked(kGlass, 1));
                 }});
  all.push_back({"glass, water, air: three deep", [](Scene& scene) {
                   add_ball(scene, "glass", {0, 0, 0}, 1.4F, 24, ranked(kGlass, 0));
                   add_ball(scene, "water", {0.1F, 0, 0.2F}, 1, 24, ranked(kWater, 1));
                   add_ball(scene, "bubble", {0.2F, 0.1F, 0.3F}, 0.6F, 24, ranked(kBubble, 2));
                 }});
  all.push_back({"blocks that share a side", [](Scene& scene) {
                   add_block(scene, "glass", {-1, -1, -1}, {0, 1, 1}, ranked(kGlass, 1));
                   add_block(scene, "water", {0, -1, -1}, {1, 1, 1}, ranked(kWater, 0));
                 }});
  all.push_back({"balls of one surface", [](Scene& scene) {
                   add_ball(scene, "water", {0, 0, 0}, 1, 24, ranked(kWater, 1));
                   add_ball(scene, "glass", {0, 0, 0}, 1, 24, ranked(kGlass, 0));
                 }});
  all.push_back({"balls of nearly one surface", [](Scene& scene) {
                   add_ball(scene, "glass", {0, 0, 0}, 1, 24, ranked(kGlass, 1));
                   add_ball(scene, "water", {0, 0, 0}, 1, 25, ranked(kWater, 0));
                   add_ball(scene, "ice", {0, 1e-7F, 0}, 1, 24, ranked(kIce, 2));
                 }});
  for (const int priority : {0, 2})
    all.push_back({"a tumbler filled to the wall", [=](Scene& scene) {
                     add_tumbler(scene, ranked(kGlass, 1));
                     add_block(scene, "water", glm::vec3(-0.75F), {0.75F, 0.4F, 0.75F}, ranked(kWater, priority));
                   }});
  all.push_back({"a tumbler filled into the wall, with ice and a bubble", [](Scene& scene) {
                   add_tumbler(scene, ranked(kGlass, 3));
                   add_block(scene, "water", glm::vec3(-0.85F), {0.85F, 0.4F, 0.85F}, ranked(kWater, 1));
                   add_block(scene, "ice", {-0.5F, 0.1F, -0.5F}, {0.1F, 0.6F, 0.1F}, ranked(kIce, 2));
                   add_ball(scene, "bubble", {0.3F, -0.2F, 0.2F}, 0.3F, 16, ranked(kBubble, 2));
                 }});
  all.push_back({"two drops of one material", [](Scene& scene) {
                   add_ball(scene, "water", {-0.4F, 0, 0}, 1, 24, ranked(kWater, 0));
                   add_ball(scene, "water", {0.4F, 0, 0}, 1, 24, kWater);
                   Primitive both = sphere({0, 0.6F, 0}, 0.8F, 16, false);
                   const Primitive more = sphere({0, 0.8F, 0.2F}, 0.8F, 16, false);
                   for (const std::uint32_t i : more.indices.list())
                     both.indices.push_back(i + std::uint32_t(both.positions_object.size()));
                   for (const glm::vec3& p : more.positions_object) both.positions_object.push_back(p);
                   add_mesh(scene, "ice", std::move(both), ranked(kIce, 0));
                 }});
  all.push_back({"seven deep, more than a path can remember", [](Scene& scene) {
                   for (int i = 0; i < 7; ++i)
                     add_ball(scene, "shell", {0.02F * float(i), 0, 0}, 1.4F - 0.15F * float(i), 16,
                              ranked(glass(1.1F + 0.1F * float(i), 0, true), i));
                 }});
  all.push_back({"seven across each other", [](Scene& scene) {
                   for (int i = 0; i < 7; ++i)
                     add_ball(scene, "ball", {0.1F * float(i) - 0.3F, 0.05F * float(i % 3), 0}, 1, 16,
                              ranked(glass(1.7F - 0.1F * float(i), 0, true), i % 4));
                 }});
  all.push_back({"shapes without a mesh", [](Scene& scene) {
                   add_round(scene, {-0.3, 0, 0}, 1, ranked(kGlass, 1));
                   add_round(scene, {0.3, 0, 0}, 1, ranked(kWater, 0));
                   add_round(scene, {0, 0.2, 0}, 0.5, ranked(kBubble, 2));
                   add_ball(scene, "ice", {0.3F, -0.4F, 0.3F}, 0.5F, 16, ranked(kIce, 3));
                 }});
  all.push_back({"dispersion on both sides", [](Scene& scene) {
                   add_ball(scene, "flint", {0, 0, 0}, 1, 24, ranked(kFlint, 0));
                   Material crown = kGlass;
                   crown.dispersion = 1;
                   add_ball(scene, "crown", {0.3F, 0, 0.1F}, 0.8F, 24, ranked(crown, 1));
                   add_ball(scene, "bubble", {-0.3F, 0, 0.3F}, 0.5F, 24, ranked(kBubble, 2));
                 }});
  all.push_back({"what rays may pass, and mirrors", [](Scene& scene) {
                   Material veil = ranked(kGlass, 1);
                   veil.alpha_mode = AlphaMode::blend;
                   veil.opacity = 0.5F;
                   add_ball(scene, "veil", {-0.3F, 0, 0}, 1, 16, veil);
                   add_ball(scene, "water", {0.4F, 0, 0}, 1, 16, ranked(kWater, 0));
                   add_ball(scene, "mirror", {0.3F, 0.5F, 0}, 0.5F, 16, ranked(glass(0, 0, true), 2));
                   add_ball(scene, "mirror within", {0.5F, -0.5F, 0}, 0.4F, 16, ranked(glass(0, 0, true), -1));
                 }});
  return all;
}

TEST(NestedMedia, M16_solids_across_and_against_each_other_neither_make_nor_lose_light) {
  for (const Arrangement& arrangement : arrangements())
    for (const bool wide : {true, false}) {
      Scene scene;
      arrangement.build(scene);
      Settings settings = settings_for(16, 16, 16);
      settings.roulette_depth = 1000;  // total reflection keeps paths for long; roulette would make them heavy
      settings.environment.radiance = glm::vec3(1);
      settings.camera = look_at_camera({0.3, 0.9, 4}, {0, 0, 0}, {0, 1, 0}, 0.75);
      const Film film = film_of(scene, settings, in_lanes(wide));
      const std::string what = std::string(arrangement.name) + (wide ? ", lanes" : ", queues");
      EXPECT_TRUE(agrees(mean_of(film), 1, 2 * int(arrangements().size()), 1e-4)) << what;
      // Every sample is 1 but for rounding; where one channel is chosen of three, three times 1 or
      // nothing.
      const bool disperses = scene.materials[0].dispersion > 0;
      for (std::uint32_t y = 0; y < 16 && !disperses; ++y)
        for (std::uint32_t x = 0; x < 16; ++x)
          ASSERT_NEAR(film.mean(x, y, 0), 1, 1e-3) << what << ", pixel " << x << ',' << y;
    }
}

TEST(NestedMedia, M16_a_camera_sees_the_sky_at_the_square_of_the_index_of_the_highest_solid_around_it) {
  struct Case {
    glm::dvec3 eye;
    double index;
  };
  for (const int order : {0, 1}) {
    Scene scene;
    add_ball(scene, "water", {-0.5F, 0, 0}, 1, 24, ranked(kWater, 2 * order));
    add_ball(scene, "glass", {0.5F, 0, 0}, 1, 24, ranked(kGlass, 1));
    add_ball(scene, "bubble", {0.5F, 0, 0}, 0.3F, 24, ranked(kBubble, 3));
    const double overlap = order == 0 ? 1.5 : double(1.333F);
    for (const Case& c : {Case{{-1.1, 0.1, 0.2}, double(1.333F)}, Case{{0, 0.2, 0.1}, overlap},
                          Case{{1.2, -0.1, 0.1}, 1.5}, Case{{0.5, 0.05, 0.1}, 1}})
      for (const bool wide : {true, false}) {
        Settings settings = settings_for(16, 16, 32);
        settings.roulette_depth = 1000;
        settings.environment.radiance = glm::vec3(1);
        settings.camera = look_at_camera(c.eye, c.eye + glm::dvec3(0.2, 0.1, -1), {0, 1, 0}, 1.2);
        const MeanAndError radiance = mean_of(film_of(scene, settings, in_lanes(wide)));
        EXPECT_TRUE(agrees(radiance, c.index * c.index, 16, 1e-4)) << c.eye.x;
      }
  }
}

TEST(NestedMedia, M15_light_falls_off_by_what_the_highest_solid_absorbs_over_its_way) {
  const auto radiance = [](const std::function<void(Scene&)>& build) {
    Scene scene;
    add_lamp(scene);
    build(scene);
    return mean_of(film_of(scene, settings_for_beam({0.1, 0.2, 4.5}, {0.1, 0.2, 0}, 16))).mean;
  };
  const auto half = [](int priority) { return ranked(amber(0.5F, 1), priority); };
  const auto quarter = [](int priority) { return ranked(amber(0.25F, 1), priority); };
  struct Case {
    double expected;
    const char* name;
    std::function<void(Scene&)> build;
  };
  const std::vector<Case> cases = {
      {std::pow(0.5, 3) * std::pow(0.25, 2), "inside, higher",
       [&](Scene& s) { add_layer(s, "a", -3, 2, half(0)), add_layer(s, "b", -1, 1, quarter(1)); }},
      {std::pow(0.5, 5), "inside, lower",
       [&](Scene& s) { add_layer(s, "a", -3, 2, half(1)), add_layer(s, "b", -1, 1, quarter(0)); }},
      {std::pow(0.5, 4) * std::pow(0.25, 2), "across, the farther lower",
       [&](Scene& s) { add_layer(s, "a", -1, 3, half(1)), add_layer(s, "b", -3, 1, quarter(0)); }},
      {std::pow(0.5, 2) * std::pow(0.25, 4), "across, the nearer lower",
       [&](Scene& s) { add_layer(s, "a", -1, 3, half(0)), add_layer(s, "b", -3, 1, quarter(1)); }},
      {std::pow(0.5, 5), "two of one material",
       [&](Scene& s) { add_layer(s, "a", -2, 1, half(0)), add_layer(s, "b", -1, 3, half(0)); }},
      {0.5 * std::pow(0.25, 2) * std::pow(0.125, 1), "three deep",
       [&](Scene& s) {
         add_layer(s, "c", -0.5F, 0.5F, ranked(amber(0.125F, 1), 9));
         add_layer(s, "a", -2, 2, half(-9));
         add_layer(s, "b", -1.5F, 1.5F, quarter(0));
       }},
      {std::pow(0.25, 1), "a clear bubble",
       [&](Scene& s) { add_layer(s, "a", -2, 1, quarter(0)), add_layer(s, "b", -2.5F, 0, ranked(kBubble, 1)); }},
      {std::pow(0.5, 1) * std::pow(0.25, 1), "clear, then two that absorb, each with an end that is hidden",
       [&](Scene& s) {
         add_layer(s, "clear", 0, 2, ranked(kBubble, 5));
         add_layer(s, "a", -1, 1, half(3));
         add_layer(s, "b", -2, 1.5F, quarter(1));
       }},
  };
  for (const Case& c : cases) EXPECT_NEAR(radiance(c.build), c.expected, 1e-5 * c.expected) << c.name;
}

// Of two layers that overlap by half a metre the higher has it: the beam is shifted by the sum of d
// tan(angle), with n sin(angle) the same in all. A lamp whose edge is 2 mm before or behind that
// place is seen or not.
TEST(NestedMedia, refraction_through_a_stack_is_Snells) {
  constexpr double kAngle = 0.7;
  const auto tangent = [&](double index) { return std::tan(std::asin(std::sin(kAngle) / index)); };
  for (const bool glass_higher : {true, false}) {
    const double in_glass = glass_higher ? 1.0 : 0.5, in_water = glass_higher ? 1.0 : 1.5;
    const double lands = 3 * tangent(1) + in_glass * tangent(double(1.5F)) + in_water * tangent(double(1.333F));
    for (const double before : {0.002, -0.002}) {
      Scene scene;
      add_layer(scene, "glass", -1, 0, ranked(kGlass, glass_higher ? 1 : 0));
      add_layer(scene, "water", -2, -0.5F, ranked(kWater, glass_higher ? 0 : 1));
      Primitive lamp;
      add_quad(lamp, {float(lands - before), -5, -5}, {10, 0, 0}, {0, 10, 0});
      add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
      Settings settings = settings_for_beam({-4 * std::tan(kAngle), 0, 4}, {0, 0, 0}, 1024);
      // Straight through: glass, where it or the water ends and shows, the water's end, the lamp.
      settings.max_depth = 4;
      const MeanAndError seen = mean_of(film_of(scene, settings));
      if (before > 0) {
        EXPECT_NEAR(seen.mean, 0.92, 0.04) << glass_higher;
      } else {
        EXPECT_EQ(seen.mean, 0) << glass_higher;
      }
    }
  }
}

// A lamp behind an eye in the outer solid, mirrored by the boundary of the inner one.
MeanAndError mirrored(const Material& outer, const Material& inner, double angle, std::uint64_t spp) {
  Scene scene;
  add_block(scene, "outer", {-30, -30, -10}, {30, 30, 20}, ranked(outer, 0));
  add_block(scene, "inner", {-29, -29, -9}, {29, 29, 0}, ranked(inner, 1));
  Primitive lamp;
  add_quad(lamp, {-25, -25, 10}, {0, 50, 0}, {50, 0, 0});  // front to -z
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
  Settings settings = settings_for_beam({-3 * std::tan(angle), 0, 3}, {0, 0, 0}, spp);
  settings.max_depth = 2;
  return mean_of(film_of(scene, settings));
}

TEST(NestedMedia, glass_in_water_reflects_by_the_index_of_both) {
  const double ratio = (1.5 - 1.333) / (1.5 + 1.333);
  EXPECT_TRUE(agrees(mirrored(kWater, kGlass, 0, 1 << 17), ratio * ratio, 3));  // 0.0035; in air it would be 0.04
  EXPECT_TRUE(agrees(mirrored(kGlass, kWater, 0, 1 << 17), ratio * ratio, 3));
  EXPECT_TRUE(agrees(mirrored(kGlass, kBubble, 0, 1 << 15), 0.04, 3));
}

TEST(NestedMedia, a_bubble_in_glass_reflects_all_beyond_the_critical_angle) {
  const double critical = std::asin(1 / 1.5);
  EXPECT_NEAR(mirrored(kGlass, kBubble, critical + 0.005, 64).mean, 1, 1e-5);
  EXPECT_LT(mirrored(kGlass, kBubble, critical - 0.02, 1024).mean, 0.7);
  EXPECT_NEAR(mirrored(kGlass, glass(0, 0, true), 0.3, 64).mean, 1, 1e-5);  // an index that stands for a mirror's
}

// Of one index, a boundary changes nothing however rough it is; hidden ones do not scatter,
// whatever they are.
TEST(NestedMedia, what_does_not_show_scatters_nothing) {
  Scene scene;
  add_lamp(scene);
  add_layer(scene, "clear", -3, 3, ranked(kBubble, 5));
  Material milk = ranked(glass(1.5F, 0.7F, true), 0);
  milk.transmission = 0.2F;
  milk.clearcoat = 1;
  milk.sheen_color = glm::vec3(1);
  add_layer(scene, "milk", -2, 2, milk);
  add_layer(scene, "flint", -1, 1, ranked(kFlint, 1));
  const Film film = film_of(scene, settings_for_beam({0.1, 0.2, 4.5}, {0.1, 0.2, 0}, 16));
  for (std::uint32_t channel = 0; channel < 3; ++channel) EXPECT_NEAR(mean_of(film, channel).mean, 1, 1e-6);
}

/// Rough balls across each other that absorb, with a lamp and a wall inside and others outside.
std::pair<Scene, Settings> murky(std::uint64_t spp) {
  Scene scene;
  Material resin = amber(0.6F, 1.5F), syrup = amber(0.8F, 1.33F);
  resin.roughness = 0.5F;
  syrup.roughness = 0.3F;
  syrup.attenuation_color = {0.9F, 0.6F, 0.3F};
  add_ball(scene, "resin", {-0.4F, 0, 0}, 1, 12, ranked(resin, 1));
  add_ball(scene, "syrup", {0.5F, 0, 0}, 1, 12, ranked(syrup, 0));
  add_block(scene, "wall", {-0.2F, -0.6F, -0.5F}, {0.7F, -0.3F, 0.4F}, lambert(0.7F));
  add_block(scene, "lamp within", {0.1F, 0.2F, -0.1F}, {0.3F, 0.4F, 0.1F}, lambert(0, 2));
  add_block(scene, "lamp", {-0.5F, 1.5F, -0.5F}, {0.5F, 1.6F, 0.5F}, lambert(0, 4));
  Settings settings = settings_for(16, 16, spp);
  settings.camera = look_at_camera({0.1, 0.5, 4}, {0, 0, 0}, {0, 1, 0}, 0.6);
  settings.environment.radiance = glm::vec3(0.2F);
  settings.max_depth = 10;
  return {std::move(scene), settings};
}

TEST(NestedMedia, every_way_of_finding_light_has_the_same_mean) {
  auto [scene, settings] = murky(1024);
  const Film mis = film_of(scene, settings);
  for (const LightSampling sampling : {LightSampling::light, LightSampling::bsdf}) {
    settings.light_sampling = sampling;
    settings.seed = 1 + std::uint32_t(sampling);
    settings.sample_end = 4096;
    const Film other = film_of(scene, settings);
    for (std::uint32_t channel = 0; channel < 3; ++channel)
      EXPECT_TRUE(agree(mean_of(mis, channel), mean_of(other, channel), 6)) << int(sampling) << ", channel " << channel;
  }
}

TEST(NestedMedia, the_order_of_meshes_and_materials_and_the_ways_to_trace_change_no_bit) {
  const auto [scene, settings] = murky(8);
  const Film film = film_of(scene, settings);
  EXPECT_TRUE(same_film(film, film_of(scene, settings, in_lanes(false))));
  Scene turned = scene;  // nothing of it coincides, so that no tie goes to the first
  std::ranges::reverse(turned.nodes);
  std::ranges::reverse(turned.materials);
  for (Mesh& mesh : turned.meshes)
    for (Primitive& primitive : mesh.primitives)
      primitive.material = std::uint32_t(turned.materials.size() - 1 - primitive.material);
  Settings by_scattering = settings;  // the order of lights decides which is sampled
  by_scattering.light_sampling = LightSampling::bsdf;
  EXPECT_TRUE(same_film(film_of(scene, by_scattering), film_of(turned, by_scattering)));
}

TEST(NestedMedia, solids_apart_from_each_other_look_as_without_priorities_to_the_bit) {
  Scene scene;
  add_ball(scene, "amber", {-1.1F, 0, 0}, 1, 16, amber(0.5F, 1.5F));
  Material rough = amber(0.7F, 1.3F);
  rough.roughness = 0.3F;
  add_ball(scene, "rough", {1.1F, 0, 0}, 1, 16, rough);
  add_ball(scene, "flint", {0, 1.9F, 0}, 1, 16, kFlint);
  add_lamp(scene);
  Settings settings = settings_for(24, 24, 16);
  settings.roulette_depth = 1000;  // which goes by the square of the index, rounded another way
  settings.camera = look_at_camera({0, 0.5, 6}, {0, 0.5, 0}, {0, 1, 0}, 0.8);
  settings.max_depth = 20;
  const Film without = film_of(scene, settings);
  for (std::size_t i = 0; i < 3; ++i) scene.materials[i].medium_priority = int(i) - 1;
  EXPECT_TRUE(same_film(film_of(scene, settings), without));
}

}  // namespace
}  // namespace eikon::test
