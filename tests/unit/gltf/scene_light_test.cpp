// SPDX-License-Identifier: Apache-2.0
// Punctual lights of a file, as nodes place them.
#include <cmath>
#include <numbers>

#include "support/gltf_builder.h"

namespace {

using eikon::PunctualLight;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;
using scene_test::warns;

/// A document with one light under a node of its own.
Builder with_light(const Json& light, const Json& node = Json::object()) {
  Builder builder;
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {light};
  builder.json["extensionsRequired"] = {"KHR_lights_punctual"};
  Json placed = node;
  placed["extensions"]["KHR_lights_punctual"]["light"] = 0;
  builder.json["nodes"].push_back(placed);
  builder.json["scenes"][0]["nodes"] = {0, 1};
  return builder;
}

PunctualLight only_light(const Json& light, const Json& node = Json::object()) {
  const Scene scene = with_light(light, node).load();
  EXPECT_EQ(scene.lights.size(), 1U);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.unsupported.empty());
  return scene.lights.at(0);
}

TEST(SceneLights, each_kind_arrives_where_its_node_puts_it) {
  // A quarter turn about +X takes -Z to +Y; the scale counts for neither place nor direction.
  const double half = std::sqrt(0.5);
  const Json node = {
      {"name", "lamp"}, {"translation", {1, 2, 3}}, {"rotation", {half, 0, 0, half}}, {"scale", {2, 3, 4}}};
  const PunctualLight point =
      only_light({{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 8}, {"range", 5}}, node);
  EXPECT_EQ(point.kind, eikon::LightKind::point);
  EXPECT_EQ(point.name, "lamp");
  EXPECT_EQ(point.intensity, glm::vec3(8, 4, 0));
  EXPECT_EQ(point.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(point.range_m, 5.0);

  const PunctualLight sun = only_light({{"type", "directional"}, {"name", "sun"}, {"intensity", 100000}}, node);
  EXPECT_EQ(sun.kind, eikon::LightKind::directional);
  EXPECT_EQ(sun.name, "sun");
  EXPECT_EQ(sun.intensity, glm::vec3(100000));  // L19: exact in single precision
  EXPECT_NEAR(glm::distance(sun.direction, glm::dvec3(0, 1, 0)), 0, 1e-15);

  const Json cone = {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}};
  const PunctualLight spot = only_light({{"type", "spot"}, {"spot", cone}}, node);
  EXPECT_EQ(spot.kind, eikon::LightKind::spot);
  EXPECT_NEAR(glm::distance(spot.direction, glm::dvec3(0, 1, 0)), 0, 1e-15);
  EXPECT_EQ(spot.inner_cone_rad, 0.25);
  EXPECT_EQ(spot.outer_cone_rad, 0.5);
}

TEST(SceneLights, what_is_not_said_has_the_defaults_of_gltf) {
  const PunctualLight light = only_light({{"type", "spot"}, {"spot", Json::object()}});
  EXPECT_EQ(light.intensity, glm::vec3(1));
  EXPECT_EQ(light.range_m, 0.0);
  EXPECT_EQ(light.direction, glm::dvec3(0, 0, -1));
  EXPECT_EQ(light.inner_cone_rad, 0.0);
  EXPECT_DOUBLE_EQ(light.outer_cone_rad, std::numbers::pi / 4);
}

TEST(SceneLights, transforms_of_parents_move_a_light_and_each_use_is_one) {
  Builder builder = with_light({{"type", "directional"}});
  const Json use = {{"KHR_lights_punctual", {{"light", 0}}}};
  builder.json["nodes"].push_back({{"children", {3}}, {"translation", {0, 5, 0}}, {"rotation", {0, 1, 0, 0}}});
  builder.json["nodes"].push_back({{"extensions", use}, {"translation", {1, 0, 0}}});
  builder.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.lights.size(), 2U);
  EXPECT_EQ(scene.lights[1].position, glm::dvec3(-1, 5, 0));
  EXPECT_EQ(scene.lights[1].direction, glm::dvec3(0, 0, 1));
}

TEST(SceneLights, lights_that_no_node_of_the_scene_places_are_not_there) {
  Builder builder = with_light({{"type", "point"}});
  builder.json["scenes"][0]["nodes"] = {0};
  EXPECT_TRUE(builder.load().lights.empty());
}

TEST(SceneLights, L17_cones_are_clamped_and_a_sharp_edge_is_legal) {
  const auto cone = [](double inner, double outer) {
    return with_light({{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}}).load();
  };
  const Scene sharp = cone(0.5, 0.5);
  EXPECT_EQ(sharp.lights.at(0).inner_cone_rad, sharp.lights.at(0).outer_cone_rad);
  EXPECT_TRUE(sharp.warnings.empty());
  const Scene crossed = cone(0.75, 0.5);
  EXPECT_EQ(crossed.lights.at(0).inner_cone_rad, 0.5);
  EXPECT_TRUE(warns(crossed, "innerConeAngle 0.75 clamped to 0.5"));
  const Scene wide = cone(-1, 3);
  EXPECT_EQ(wide.lights.at(0).inner_cone_rad, 0.0);
  EXPECT_EQ(wide.lights.at(0).outer_cone_rad, std::numbers::pi / 2);
  EXPECT_EQ(wide.warnings.size(), 2U);
  // pi / 2 as a float is above pi / 2.
  EXPECT_TRUE(cone(0, static_cast<double>(1.57079637F)).warnings.empty());
  const Scene shut = cone(0, 0);
  EXPECT_TRUE(shut.lights.empty());
  EXPECT_TRUE(warns(shut, "lets no light out"));
}

TEST(SceneLights, L18_a_range_that_is_not_positive_is_without_end) {
  for (const double range : {0.0, -2.0}) {
    const Scene scene = with_light({{"type", "point"}, {"range", range}}).load();
    EXPECT_EQ(scene.lights.at(0).range_m, 0.0);
    EXPECT_TRUE(warns(scene, "is not positive"));
  }
}

TEST(SceneLights, negative_light_is_clamped_and_too_much_is_refused) {
  const Scene scene = with_light({{"type", "point"}, {"color", {-1, 1, 0}}, {"intensity", 3}}).load();
  EXPECT_EQ(scene.lights.at(0).intensity, glm::vec3(0, 3, 0));
  EXPECT_TRUE(warns(scene, "color -1 clamped"));
  EXPECT_EQ(with_light({{"type", "point"}, {"intensity", -3}}).load().lights.at(0).intensity, glm::vec3(0));
  EXPECT_TRUE(contains(message_of([] {
                         with_light({{"type", "point"}, {"name", "nova"}, {"intensity", 1e39}}).load();
                       }),
                       "light 'nova': intensity 1e+39"));
}

TEST(SceneLights, a_node_without_direction_gives_none_and_one_too_far_is_refused) {
  const Json flat = {{"scale", {1, 1, 0}}};
  EXPECT_TRUE(warns(with_light({{"type", "directional"}}, flat).load(), "scales its direction to nothing"));
  EXPECT_EQ(with_light({{"type", "point"}}, flat).load().lights.size(), 1U);
  EXPECT_EQ(only_light({{"type", "directional"}}, {{"scale", {1, 1, 1e-300}}}).direction, glm::dvec3(0, 0, -1));
  EXPECT_TRUE(contains(message_of([] {
                         with_light({{"type", "point"}}, {{"translation", {0, 1e13, 0}}}).load();
                       }),
                       "beyond 2^40 m"));
}

TEST(SceneLights, what_is_not_valid_is_refused_with_its_place) {
  const auto message = [](const Json& light) { return message_of([&] { with_light(light).load(); }); };
  EXPECT_TRUE(contains(message({{"type", "area"}}), "none of 'point', 'spot', 'directional'"));
  EXPECT_TRUE(contains(message(Json::object()), "light 0"));
  EXPECT_TRUE(contains(message({{"type", 3}}), "not a string"));
  EXPECT_TRUE(contains(message({{"type", "point"}, {"color", {1, 1}}}), "color"));
  EXPECT_TRUE(contains(message({{"type", "point"}, {"intensity", "8"}}), "intensity"));
  EXPECT_TRUE(contains(message({{"type", "point"}, {"name", 8}}), "name"));
  EXPECT_TRUE(contains(message({{"type", "spot"}, {"spot", {{"outerConeAngle", "wide"}}}}), "outerConeAngle"));
  EXPECT_TRUE(contains(message(3), "not an object"));
  Builder builder = with_light({{"type", "point"}});
  builder.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 1;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "node 1"));
  builder.json["nodes"][1]["extensions"]["KHR_lights_punctual"] = 7;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "node 1"));
  builder.json.erase("extensions");
  builder.json["nodes"][1]["extensions"]["KHR_lights_punctual"] = {{"light", 0}};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "there are only 0"));
}

}  // namespace
