// SPDX-License-Identifier: Apache-2.0
// These tests show that look_at_light, which packs no lights, finds what packing them gives.
#include <gtest/gtest.h>

#include <numbers>

#include "pack/geometry/instanced_meshes.h"
#include "pack/pack.h"

namespace eikon {
namespace {

/// A lone triangle, and strips of `count` cells of two triangles each, which form parallelograms
/// where `flat`.
Primitive strips(std::uint32_t count, bool flat, std::uint32_t material) {
  Primitive primitive;
  std::vector<glm::vec3> positions{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
  std::vector<std::uint32_t> indices{0, 1, 2};
  for (std::uint32_t i = 0; i <= count; ++i) {
    const float x = float(i) * 0.001F, z = flat ? 0 : 0.001F * float(i * i % 7);
    positions.emplace_back(x, 0, z);
    positions.emplace_back(x, 1, flat ? 0 : -z);
    const std::uint32_t a = 3 + 2 * i;
    if (i < count) indices.insert(indices.end(), {a, a + 2, a + 1, a + 2, a + 3, a + 1});
  }
  std::vector<glm::vec2> uv;
  for (std::size_t i = 0; i < positions.size(); ++i) uv.emplace_back(float(i % 13) / 13, float(i % 5) / 5);
  primitive.positions_object = std::move(positions);
  primitive.uv[0] = std::move(uv);
  primitive.indices = std::move(indices);
  primitive.material = material;
  return primitive;
}

/// More emissive triangles than are looked at together, of which some form pairs and some have
/// textures; shapes and other lights.
Scene bright_scene() {
  Scene scene;
  Material even, textured, dark, veil;
  even.name = "even";
  even.emission = {1, 2, 3};
  textured.name = "textured";
  textured.emission = glm::vec3(5);
  textured.double_sided = true;
  textured.emissive_texture = Texture{};
  TextureImage image;
  image.width = 2, image.height = 1;
  image.rgba8 = {0xff80ff00U, 0xff000010U};
  scene.images.push_back(image);
  veil.name = "veil";
  veil.emission = glm::vec3(2);
  veil.alpha_mode = AlphaMode::blend;
  veil.opacity = 0.5F;
  veil.base_color_texture = Texture{};
  scene.materials = {even, textured, dark, veil};
  scene.meshes = {{"even", {strips(30'000, true, 0)}},
                  {"uneven", {strips(10'000, false, 0), strips(9'000, false, 1)}},
                  {"dark", {strips(3, false, 2)}},
                  {"veil", {strips(100, false, 3)}}};
  scene.nodes.resize(5);
  for (std::uint32_t i = 0; i < 3; ++i) scene.nodes[i].mesh = i;
  scene.nodes[4].mesh = 3;
  scene.nodes[3].mesh = 0;
  scene.nodes[3].world_from_object[3] = {0, 0, 5, 1};
  PunctualLight bulb, sun;
  bulb.kind = LightKind::point, bulb.intensity = glm::vec3(3), bulb.name = "bulb";
  sun.kind = LightKind::directional, sun.intensity = glm::vec3(2), sun.name = "sun";
  scene.lights = {sun, bulb};
  return scene;
}

void expect_same(const Scene& scene, const Settings& settings) {
  const Features features(scene, settings);
  const PackedScene packed = pack_scene(scene, features, settings);
  const LightOverview light = look_at_light(scene, features, settings);
  EXPECT_TRUE(light.packed.triangles.empty());
  EXPECT_TRUE(light.packed.lights.empty());
  EXPECT_EQ(light.packed.bounds.lo, packed.bounds.lo);
  EXPECT_EQ(light.packed.bounds.hi, packed.bounds.hi);
  EXPECT_EQ(light.bytes + packed.triangle_count() * triangle_bytes(features), packed.bytes(""));
  ASSERT_EQ(light.packed.light_summary.size(), packed.light_summary.size());
  for (std::size_t i = 0; i < packed.light_summary.size(); ++i) {
    const PackedLight &a = light.packed.light_summary[i], &b = packed.light_summary[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.kind, b.kind) << a.name;
    EXPECT_EQ(a.flux, b.flux) << a.name;
    EXPECT_EQ(a.area_m2, b.area_m2) << a.name;
    EXPECT_EQ(a.strength, b.strength) << a.name;
    EXPECT_NEAR(a.probability, b.probability, 1e-6) << a.name;
    EXPECT_GT(a.probability, 0) << a.name;
  }
}

TEST(LightOverview, is_that_of_the_packed_scene_however_many_lights_there_are) {
  Scene scene = bright_scene();
  Settings settings;
  settings.environment.radiance = glm::vec3(0.1F);
  EXPECT_TRUE(Features(scene, settings).has(Feature::light_tree));
  EXPECT_TRUE(Features(scene, settings).has(Feature::quad_light));
  expect_same(scene, settings);
}

TEST(LightOverview, is_that_of_a_scene_whose_lights_have_no_tree) {
  Scene scene = bright_scene();
  Settings settings;
  scene.nodes.resize(1);
  Node wall;
  wall.mesh = 2;
  wall.world_from_object[0] *= 1e5, wall.world_from_object[1] *= 1e5;
  wall.world_from_object[0].w = wall.world_from_object[1].w = 0;
  scene.nodes.push_back(wall);
  scene.lights.resize(1);
  EXPECT_FALSE(Features(scene, settings).has(Feature::light_tree)) << "one lamp that is small beside the scene";
  expect_same(scene, settings);
  scene.nodes.erase(scene.nodes.begin());
  expect_same(scene, settings);
}

/// A square of 1 m2 whose light is 2 in each direction, with some opacity.
Scene square_of(const Material& material, std::vector<glm::vec4> colors = {}) {
  Scene scene;
  Primitive primitive;
  primitive.positions_object = std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  primitive.uv[0] = std::vector<glm::vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  primitive.indices = {0, 1, 2, 0, 2, 3};
  primitive.colors = std::move(colors);
  scene.meshes = {{"square", {primitive}}};
  scene.materials = {material};
  scene.materials[0].emission = glm::vec3(2);
  scene.nodes.resize(1);
  TextureImage image;
  image.width = 2, image.height = 1;
  image.rgba8 = {0xffffffffU, 0x33ffffffU};  // opacity 1 in the left half, .2 in the right one
  scene.images.push_back(image);
  return scene;
}

double flux_of(const Scene& scene) {
  const Settings settings;
  const LightOverview light = look_at_light(scene, Features(scene, settings), settings);
  return light.packed.light_summary.at(0).flux;
}

TEST(LightOverview, a_light_that_lets_light_pass_has_the_flux_of_what_stops_it) {
  const double whole = 2 * std::numbers::pi;
  Material veil;
  EXPECT_NEAR(flux_of(square_of(veil)), whole, 1e-6);
  veil.opacity = 0.25F;
  EXPECT_NEAR(flux_of(square_of(veil)), whole, 1e-6) << "opaque, whatever its factor is";
  veil.alpha_mode = AlphaMode::blend;
  EXPECT_NEAR(flux_of(square_of(veil)), whole / 4, 1e-6);
  EXPECT_NEAR(flux_of(square_of(veil, std::vector<glm::vec4>(4, glm::vec4(1, 1, 1, 0.5F)))), whole / 8, 1e-6);
  veil.base_color_texture = Texture{};
  veil.base_color_texture->filter = TextureFilter::nearest;
  EXPECT_NEAR(flux_of(square_of(veil)), whole / 4 * 0.6, 0.02 * whole);
  veil.opacity = 1;
  veil.alpha_mode = AlphaMode::mask;
  EXPECT_NEAR(flux_of(square_of(veil)), whole / 2, 0.02 * whole);
}

}  // namespace
}  // namespace eikon
