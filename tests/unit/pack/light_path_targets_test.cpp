// SPDX-License-Identifier: Apache-2.0
// Where light paths start, and the balls that they are aimed at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "pack/lights/pack_light_paths.h"
#include "pack/pack_parts.h"

namespace eikon {
namespace {

Material smooth_glass() {
  Material m;
  m.metallic = 0;
  m.roughness = 0;
  m.transmission = 1;
  return m;
}

/// Adds a triangle at a place. node: of which it is
void add_triangle(PackedScene& packed, const glm::vec3& at, float size, std::uint32_t node, std::uint32_t material) {
  Triangle t{};
  set_corners(t, at, at + glm::vec3(size, 0, 0), at + glm::vec3(0, size, 0));
  t.node = node;
  t.material = material;
  packed.triangles.push_back(t);
  for (const glm::vec3& p : corners_of(t)) grow(packed.bounds, p);
}

bool covers(const PackedScene& packed, const glm::vec3& p) {
  return std::ranges::any_of(packed.light_targets, [&](const float4& ball) {
    return glm::length(glm::dvec3(p) - glm::dvec3(ball.x, ball.y, ball.z)) <= double(ball.w);
  });
}

const std::vector<LightPathSource> kOneLamp = {{.radiance_area = 3, .place = {0, 50, 0}}};

TEST(LightTargets, are_the_materials_that_reflect_or_refract_exactly_or_nearly) {
  Material glass = smooth_glass(), plastic, mirror;
  plastic.metallic = 0;
  plastic.roughness = 0;
  mirror.metallic = 1;
  mirror.roughness = 0;
  EXPECT_TRUE(is_specular_light_target(glass));
  EXPECT_TRUE(is_specular_light_target(mirror));
  EXPECT_FALSE(is_light_target(plastic)) << "a few per cent of its light would take all light paths";
  for (Material m : {glass, mirror}) {
    for (const auto& [roughness, is] :
         {std::pair(0.01F, false), std::pair(0.02F, true), std::pair(0.5F, true), std::pair(0.51F, false)}) {
      m.roughness = roughness;
      EXPECT_EQ(is_glossy_light_target(m), is) << roughness;
      EXPECT_EQ(is_light_target(m), roughness < 0.51F) << roughness;
    }
    m.roughness = 0.1F;
    m.metallic *= 0.4F, m.transmission *= 0.4F;
    EXPECT_FALSE(is_light_target(m)) << "most of its light is scattered by the base";
  }
  glass.unlit = true;
  EXPECT_FALSE(is_light_target(glass));
}

TEST(LightTargets, are_the_only_way_to_some_light_if_they_are_exact_and_no_ray_meets_the_light) {
  Scene scene;
  scene.materials = {Material{}, smooth_glass()};
  EXPECT_FALSE(only_light_paths_find_some(scene)) << "no light";
  scene.lights.emplace_back().kind = LightKind::directional;
  EXPECT_FALSE(only_light_paths_find_some(scene)) << "it is off";
  scene.lights[0].intensity = {0, 2, 0};
  EXPECT_TRUE(only_light_paths_find_some(scene));
  scene.lights[0].kind = LightKind::point;
  EXPECT_TRUE(only_light_paths_find_some(scene));
  scene.lights[0].range_m = 5;
  EXPECT_FALSE(only_light_paths_find_some(scene)) << "no light path starts from there";
  scene.lights[0].range_m = 0;
  scene.materials[1].roughness = 0.2F;
  EXPECT_FALSE(only_light_paths_find_some(scene)) << "light sampling finds it on rough glass";
}

TEST(LightTargets, cover_every_corner_with_no_more_balls_than_kernels_look_at) {
  const std::vector<Material> materials = {Material{}, smooth_glass()};
  for (const std::uint32_t nodes : {1U, 5U, 64U, 65U, 1000U}) {
    PackedScene packed;
    for (std::uint32_t node = 0; node < nodes; ++node)
      for (std::uint32_t i = 0; i < 4; ++i)
        add_triangle(packed, {float(node % 32), float(node / 32), 0.3F * float(i)}, 0.2F, node, 1);
    add_triangle(packed, {500, 0, 0}, 1, 9999, 0);
    pack_light_paths(materials, kOneLamp, packed);
    EXPECT_LE(packed.light_targets.size(), std::size_t{EK_LIGHT_TARGETS_MOST});
    EXPECT_GE(packed.light_targets.size(), std::min(nodes, 5U));
    for (const Triangle& t : packed.triangles)
      for (const glm::vec3& p : corners_of(t)) EXPECT_EQ(covers(packed, p), t.material == 1) << nodes;
  }
}

TEST(LightTargets, are_divided_where_they_are_large) {
  const std::vector<Material> materials = {smooth_glass()};
  PackedScene packed;
  for (int i = 0; i < 400; ++i) add_triangle(packed, {float(i % 20), float(i / 20), 0}, 1, 0, 0);  // one pane
  pack_light_paths(materials, kOneLamp, packed);
  EXPECT_GT(packed.light_targets.size(), 16U);
  const double scene = 0.5 * glm::length(packed.bounds.hi - packed.bounds.lo);
  for (const float4& ball : packed.light_targets) EXPECT_LT(ball.w, 0.25 * scene);
}

TEST(LightTargets, are_divided_where_one_triangle_is_large) {
  const std::vector<Material> materials = {smooth_glass()};
  PackedScene packed;
  add_triangle(packed, {0, 0, 0}, 4, 0, 0);
  add_triangle(packed, {100, 0, 0}, 0.1F, 1, 0);
  pack_light_paths(materials, kOneLamp, packed);
  EXPECT_EQ(packed.light_targets.size(), 2U) << "both are small beside the scene";

  packed = {};
  add_triangle(packed, {0, 0, 0}, 4, 0, 0);
  packed.triangles.push_back(packed.triangles.front());
  set_corners(packed.triangles.back(), {4, 4, 0}, {4, 0, 0}, {0, 4, 0});  // the other half of a square pane
  pack_light_paths(materials, kOneLamp, packed);
  EXPECT_GT(packed.light_targets.size(), 16U);
  const double scene = 0.5 * glm::length(packed.bounds.hi - packed.bounds.lo);
  for (const float4& ball : packed.light_targets) EXPECT_LT(ball.w, 0.25 * scene);
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 40; ++j) EXPECT_TRUE(covers(packed, {0.1F * float(i), 0.1F * float(j), 0}));
}

TEST(LightTargets, are_whole_around_a_shape) {
  PackedScene packed;
  Triangle box{};
  set_corners(box, {0, 0, 0}, {4, 4, 4}, {0, 0, 0});  // of a shape: its least and greatest corner
  packed.triangles.push_back(box);
  packed.shapes.resize(1);
  grow(packed.bounds, glm::vec3(0)), grow(packed.bounds, glm::vec3(4));
  pack_light_paths(std::vector<Material>{smooth_glass()}, kOneLamp, packed);
  EXPECT_EQ(packed.light_targets.size(), 1U);
}

TEST(LightTargets, take_lights_by_what_they_send_there) {
  const std::vector<Material> materials = {smooth_glass(), Material{}};
  PackedScene packed;
  add_triangle(packed, {0, 0, 0}, 1, 0, 0);
  add_triangle(packed, {0, -100, 0}, 1, 1, 1);  // beside which the glass is small, so that it is one target
  const std::vector<LightPathSource> lights = {
      {.radiance_area = 4, .area_m2 = 0.5, .place = {0, 10, 0}},  // a lamp
      {.radiance_area = 4, .place = {0, 1000, 0}},  // a bulb a hundred times as far: its share is 2^-8 / n at least
      {.irradiance = 2},                            // a sun
      {},                                           // an environment
  };
  pack_light_paths(materials, lights, packed);
  ASSERT_EQ(packed.emission_pdf.size(), 4U);
  EXPECT_EQ(packed.emission_pdf[3], 0.0F);
  const double sum =
      0.5 * double(packed.emission_pdf[0]) + double(packed.emission_pdf[1]) + double(packed.emission_pdf[2]);
  EXPECT_NEAR(sum, 1, 1e-6) << "of the lamp it is a density per m^2";
  EXPECT_GT(packed.emission_pdf[2], 10 * 0.5F * packed.emission_pdf[0]);
  EXPECT_NEAR(double(packed.emission_pdf[1]), 1.0 / 256 / 4, 2e-4);
  // Directions to the target, as seen from the lamp and from the bulb, per sr: the powers of two
  // below.
  for (const auto& [light, distance] : {std::pair(0, 10.0), std::pair(1, 1000.0)}) {
    const double per_sr = distance * distance / (std::numbers::pi * std::pow(double(packed.light_targets[0].w), 2));
    const double aim = double(packed.emission_aim[std::size_t(light) + 1]);
    EXPECT_GT(aim, 0.49 * per_sr);
    EXPECT_LT(aim, 1.01 * per_sr);
    EXPECT_EQ(aim, std::exp2(std::round(std::log2(aim))));
  }
}

TEST(LightTargets, without_light_or_glass_there_are_none) {
  PackedScene packed;
  add_triangle(packed, {0, 0, 0}, 1, 0, 0);
  pack_light_paths(std::vector<Material>{smooth_glass()}, std::vector<LightPathSource>(2), packed);
  EXPECT_TRUE(packed.light_targets.empty() && packed.emission_alias_table.empty());
  EXPECT_EQ(packed.emission_pdf, std::vector<float>(2)) << "which paths from the camera look up";
  EXPECT_EQ(packed.emission_aim, std::vector<float>(3));
  pack_light_paths(std::vector<Material>{Material{}}, kOneLamp, packed);
  EXPECT_TRUE(packed.light_targets.empty() && packed.emission_alias_table.empty());
  EXPECT_EQ(packed.emission_pdf, std::vector<float>(1));
  EXPECT_EQ(packed.emission_aim, std::vector<float>(2));
}

}  // namespace
}  // namespace eikon
