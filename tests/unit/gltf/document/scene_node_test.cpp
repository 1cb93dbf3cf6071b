// SPDX-License-Identifier: Apache-2.0
// The graph of nodes, and looking at what it places.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;
using scene_test::warns;

const glm::dmat4& transform(const Scene& scene, std::size_t node = 0) { return scene.nodes.at(node).world_from_object; }

double largest_difference(const glm::dmat4& a, const glm::dmat4& b) {
  double largest = 0;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) largest = std::max(largest, std::abs(a[c][r] - b[c][r]));
  }
  return largest;
}

// (p1 - p0) x (p2 - p0) of the first triangle in the world, with the corners in the order that
// `mirrored` asks for.
glm::dvec3 world_normal(const Scene& scene) {
  const eikon::Node& node = scene.nodes.at(0);
  const eikon::Primitive& primitive = scene.meshes.at(node.mesh).primitives.at(0);
  glm::dvec3 p[3];
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = glm::dvec3(node.world_from_object * glm::dvec4(primitive.positions_object[primitive.indices[k]], 1.0));
  }
  if (node.mirrored) std::swap(p[1], p[2]);
  return glm::cross(p[1] - p[0], p[2] - p[0]);
}

TEST(SceneNodes, translation_rotation_and_scale_apply_in_the_order_of_gltf) {
  Builder builder;
  builder.node()["translation"] = {1, 2, 3};
  builder.node()["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // a quarter turn about z
  builder.node()["scale"] = {2, 3, 4};
  const Scene scene = builder.load();
  EXPECT_EQ(transform(scene) * glm::dvec4(1, 1, 1, 1), glm::dvec4(1 - 3, 2 + 2, 3 + 4, 1));  // exact: a quarter turn
}

TEST(SceneNodes, rotations_agree_with_their_matrix_about_any_axis) {
  for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(1, -2, 3)}) {
    const double angle = 0.7;
    const glm::dvec3 imaginary = glm::normalize(axis) * std::sin(angle / 2);
    Builder builder;
    builder.node()["rotation"] = {imaginary.x, imaginary.y, imaginary.z, std::cos(angle / 2)};
    EXPECT_LT(largest_difference(transform(builder.load()), glm::rotate(glm::dmat4(1.0), angle, axis)), 1e-15);
  }
}

TEST(SceneNodes, matrices_are_stored_by_columns_and_parents_apply_last) {
  Builder builder;
  builder.json["nodes"] = {{{"children", {1}}, {"matrix", {1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}},
                           {{"mesh", 0}, {"scale", {1, 2, 1}}}};
  const Scene scene = builder.load();
  const glm::dvec4 moved = transform(scene) * glm::dvec4(0, 1, 0, 1);  // scaled to y = 2, sheared by 1, moved by 10
  EXPECT_EQ(moved, glm::dvec4(11, 2, 0, 1));
}

TEST(SceneNodes, G16_extreme_scales_and_shear_through_parents_keep_normals_across_their_triangles) {
  Builder builder;
  builder.json["nodes"] = {{{"children", {1}}, {"scale", {1, 1e-3, 1e3}}},
                           {{"children", {2}}, {"rotation", {0.1, 0.2, 0.3, 0.9}}},
                           {{"mesh", 0}, {"scale", {1, 5, 0.2}}}};
  const Scene scene = builder.load();
  const glm::dmat3 linear(transform(scene));
  // The object-space normal is z; it maps by the inverse transpose and must stand on both edges.
  const glm::dvec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) * glm::dvec3(0, 0, 1));
  EXPECT_LT(std::abs(glm::dot(normal, glm::normalize(linear[0]))), 1e-5);
  EXPECT_LT(std::abs(glm::dot(normal, glm::normalize(linear[1]))), 1e-5);
  EXPECT_GT(glm::dot(normal, world_normal(scene)), 0.0);
  EXPECT_FALSE(scene.nodes[0].mirrored);
}

TEST(SceneNodes, G17_a_negative_determinant_keeps_the_front_in_front) {
  Builder builder;
  builder.node()["scale"] = {-1, 1, 1};
  const Scene mirrored = builder.load();
  EXPECT_TRUE(mirrored.nodes[0].mirrored);
  EXPECT_GT(world_normal(mirrored).z, 0.0);  // as in object space
  builder.node()["scale"] = {-1, -1, 1};
  EXPECT_FALSE(builder.load().nodes[0].mirrored);
  builder.node()["scale"] = {-1, -1, -1};
  const Scene turned = builder.load();
  EXPECT_TRUE(turned.nodes[0].mirrored);
  EXPECT_LT(world_normal(turned).z, 0.0);  // the mesh is seen from its other side of z
}

TEST(SceneNodes, G18_scale_zero_flattens_and_odd_quaternions_are_normalised_or_refused) {
  Builder flat;
  flat.node()["scale"] = {1, 0, 1};
  const Scene scene = flat.load();
  EXPECT_FALSE(scene.nodes.at(0).mirrored);
  EXPECT_EQ(eikon::world_bounds(scene).hi, glm::dvec3(1, 0, 0));

  Builder twice;
  twice.node()["rotation"] = {0, 0, 0, 2};
  const Scene normalised = twice.load();
  EXPECT_EQ(transform(normalised), glm::dmat4(1.0));
  EXPECT_TRUE(warns(normalised, "node 'triangle': rotation of length 2"));
  twice.node()["rotation"] = {0, 0, 1e-200, 1e-200};
  EXPECT_NEAR(transform(twice.load())[0][1], 1.0, 1e-15);

  Builder none;
  none.node()["rotation"] = {0, 0, 0, 0};
  EXPECT_TRUE(contains(message_of([&] { none.load(); }), "node 'triangle': rotation (0, 0, 0, 0)"));
}

TEST(SceneNodes, G20_a_cycle_is_called_NODE_LOOP_with_the_names_in_it) {
  Builder builder;
  builder.json["nodes"] = {{{"name", "root"}, {"children", {1}}},
                           {{"name", "hen"}, {"children", {2}}, {"mesh", 0}},
                           {{"name", "egg"}, {"children", {1}}}};
  std::string message = message_of([&] { builder.load(); });
  EXPECT_TRUE(contains(message, "NODE_LOOP: node 'hen' -> node 'egg' -> node 'hen'"));
  // Out of reach of the scene, it is still a broken file.
  builder.json["nodes"][0].erase("children");
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "NODE_LOOP"));
  builder.json["nodes"][1]["children"] = {1};
  builder.json["nodes"][2].erase("children");
  message = message_of([&] { builder.load(); });
  EXPECT_TRUE(contains(message, "NODE_LOOP: node 'hen' -> node 'hen'"));
}

TEST(SceneNodes, G20_a_chain_of_ten_thousand_nodes_loads_and_one_of_a_loop_is_refused) {
  Builder builder;
  builder.json["nodes"] = Json::array();
  constexpr std::size_t kDepth = 10000;
  for (std::size_t i = 0; i < kDepth; ++i) {
    builder.json["nodes"].push_back({{"translation", {0.5, 0, 0}}});
    if (i + 1 < kDepth) builder.json["nodes"][i]["children"] = {i + 1};
  }
  builder.json["nodes"][kDepth - 1]["mesh"] = 0;
  EXPECT_EQ(transform(builder.load())[3].x, 5000.0);
  builder.json["nodes"][kDepth - 1]["children"] = {0};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "NODE_LOOP"));
}

TEST(SceneNodes, a_node_with_two_parents_stands_under_both) {
  Builder shared;
  shared.json["nodes"] = {{{"name", "a"}, {"children", {2}}, {"translation", {1, 0, 0}}},
                          {{"name", "b"}, {"children", {2}}, {"translation", {0, 2, 0}}},
                          {{"name", "c"}, {"mesh", 0}}};
  shared.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = shared.load();
  ASSERT_EQ(scene.nodes.size(), 2U);
  EXPECT_EQ(scene.nodes[0].world_from_object[3], glm::dvec4(1, 0, 0, 1));
  EXPECT_EQ(scene.nodes[1].world_from_object[3], glm::dvec4(0, 2, 0, 1));
  EXPECT_EQ(scene.meshes.size(), 1U);
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "node 'c' is a child of both node 'a' and node 'b'"));
}

TEST(SceneNodes, children_that_multiply_without_end_and_repeats_are_refused) {
  Builder twofold;  // 2^40 places from 80 nodes
  twofold.json["nodes"] = Json::array();
  for (std::size_t i = 0; i < 80; i += 2) {
    const Json children = i + 2 < 80 ? Json({i + 2, i + 3}) : Json::array();
    for (int k = 0; k < 2; ++k) twofold.json["nodes"].push_back({{"children", children}});
  }
  EXPECT_TRUE(contains(message_of([&] { twofold.load(); }), "too many nodes"));
  Builder repeated;
  repeated.json["scenes"][0]["nodes"] = {0, 0};
  EXPECT_TRUE(contains(message_of([&] { repeated.load(); }), "node 'triangle' twice"));
  repeated.json["nodes"] = {{{"name", "a"}, {"children", {1, 1}}}, {{"name", "b"}}};
  repeated.json["scenes"][0]["nodes"] = {0};
  EXPECT_TRUE(contains(message_of([&] { repeated.load(); }), "node 'a' lists node 'b' twice"));
}

TEST(SceneNodes, a_listed_child_stands_once_where_its_parent_puts_it_or_alone_if_the_scene_lacks_that) {
  Builder listed;
  listed.json["nodes"] = {{{"name", "a"}, {"children", {1}}, {"translation", {1, 0, 0}}},
                          {{"name", "b"}, {"children", {2}}},
                          {{"name", "c"}, {"mesh", 0}}};
  listed.json["scenes"][0]["nodes"] = {2, 0, 1};
  Scene scene = listed.load();
  ASSERT_EQ(scene.nodes.size(), 1U);
  EXPECT_EQ(scene.nodes[0].world_from_object[3], glm::dvec4(1, 0, 0, 1));
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "lists node 'c', a child of node 'b'; it stands where its parent"));
  EXPECT_TRUE(contains(scene.out_of_range[0], "(2 such nodes)"));
  listed.json["scenes"][0]["nodes"] = {2};
  scene = listed.load();
  ASSERT_EQ(scene.nodes.size(), 1U);
  EXPECT_EQ(scene.nodes[0].world_from_object[3], glm::dvec4(0, 0, 0, 1));
  EXPECT_TRUE(contains(scene.out_of_range.at(0), "without its parent"));
}

TEST(SceneNodes, an_invisible_node_hides_all_below_it_but_cameras) {
  Builder builder;
  const Json hidden = {{"KHR_node_visibility", {{"visible", false}}}},
             shown = {{"KHR_node_visibility", {{"visible", true}}}};
  builder.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}}}}}}};
  builder.json["cameras"] = {{{"name", "eye"}, {"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  builder.json["nodes"] = {{{"children", {1, 2}}, {"extensions", hidden}},
                           {{"mesh", 0}, {"camera", 0}, {"extensions", shown}},
                           {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                           {{"name", "seen"}, {"mesh", 0}, {"extensions", shown}}};
  builder.json["scenes"][0]["nodes"] = {0, 3};
  builder.json["extensionsRequired"] = {"KHR_node_visibility"};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.nodes.size(), 1U);
  EXPECT_EQ(scene.nodes[0].name, "seen");
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_EQ(scene.cameras.size(), 1U);
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());
  builder.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = 0;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "'visible' is neither true nor false"));
}

TEST(SceneNodes, the_default_scene_counts_else_the_first_else_all_roots) {
  Builder builder;
  builder.json["nodes"] = {{{"name", "one"}, {"mesh", 0}},
                           {{"name", "two"}, {"mesh", 0}, {"children", {2}}},
                           {{"name", "three"}, {"mesh", 0}}};
  builder.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  builder.json["scene"] = 1;
  Scene scene = builder.load();
  ASSERT_EQ(scene.nodes.size(), 2U);
  EXPECT_EQ(scene.nodes[0].name, "two");
  builder.json.erase("scene");
  scene = builder.load();
  ASSERT_EQ(scene.nodes.size(), 1U);
  EXPECT_EQ(scene.nodes[0].name, "one");
  builder.json.erase("scenes");
  EXPECT_EQ(builder.load().nodes.size(), 3U);
}

TEST(SceneNodes, a_matrix_beside_other_transforms_wins_with_a_warning) {
  Builder builder;
  builder.node()["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
  builder.node()["translation"] = {5, 5, 5};
  const Scene scene = builder.load();
  EXPECT_EQ(transform(scene)[3], glm::dvec4(0, 0, 0, 1));
  EXPECT_TRUE(warns(scene, "node 'triangle': has a matrix"));
}

TEST(SceneView, bounds_enclose_the_triangles_in_the_world) {
  Builder builder;
  builder.node()["translation"] = {1, 2, 3};
  builder.node()["scale"] = {-2, 1, 1};
  const eikon::Bounds bounds = eikon::world_bounds(builder.load());
  EXPECT_EQ(bounds.lo, glm::dvec3(-1, 2, 3));
  EXPECT_EQ(bounds.hi, glm::dvec3(1, 3, 3));
}

TEST(SceneView, look_at_looks_along_minus_z_with_up_upwards) {
  const eikon::Camera camera = eikon::look_at_camera({1, 2, 3}, {1, 2, -5}, {0, 7, 1}, 0.6);
  EXPECT_EQ(camera.world_from_camera[3], glm::dvec4(1, 2, 3, 1));
  EXPECT_EQ(camera.world_from_camera[2], glm::dvec4(0, 0, 1, 0));
  EXPECT_EQ(camera.world_from_camera[1], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(camera.world_from_camera[0], glm::dvec4(1, 0, 0, 0));
  EXPECT_EQ(camera.yfov_rad, 0.6);
}

TEST(SceneView, look_at_refuses_what_gives_no_view) {
  EXPECT_THROW((void)eikon::look_at_camera({1, 2, 3}, {1, 2, 3}, {0, 1, 0}, 0.6), eikon::UsageError);
  EXPECT_THROW((void)eikon::look_at_camera({0, 0, 0}, {0, 5, 0}, {0, 1, 0}, 0.6), eikon::UsageError);
  EXPECT_THROW((void)eikon::look_at_camera({0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 0.6), eikon::UsageError);
  EXPECT_THROW((void)eikon::look_at_camera({NAN, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.6), eikon::UsageError);
  EXPECT_THROW((void)eikon::look_at_camera({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 4), eikon::UsageError);
}

}  // namespace
