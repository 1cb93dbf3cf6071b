// SPDX-License-Identifier: Apache-2.0
// Skins: vertices against matrices by hand, skeletons anywhere in the graph, and skins that are
// wrong.
#include <cmath>
#include <functional>
#include <limits>

#include "scene/transform.h"
#include "support/animation_builder.h"

namespace {

using eikon::Primitive;
using eikon::Scene;
using scene_test::add_channel;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedShort;
using scene_test::load_at;
using scene_test::message_of;
using scene_test::target_of;
using scene_test::warns;

using Matrices = std::vector<glm::dmat4>;

const eikon::TriangleIndices kAsInFile{0, 1, 2}, kTurned{0, 2, 1};

glm::dmat4 turned(double degrees, const glm::dvec3& scale = glm::dvec3(1), const glm::dvec3& at = glm::dvec3(0)) {
  const double half = degrees * 3.14159265358979323846 / 360;
  return eikon::transform_matrix(at, {0, 0, std::sin(half), std::cos(half)}, scale);
}

Json column_major(const glm::dmat4& m) {
  Json numbers = Json::array();
  for (int i = 0; i < 16; ++i) numbers.push_back(m[i / 4][i % 4]);
  return numbers;
}

/// The triangle under node 0, whose own transform does not count, with joints at nodes 1 to n as
/// `places` has them. Corners follow joints (0), (0, 1), (1).
Builder skinned(const Matrices& places, const Matrices& binds = {}) {
  Builder builder;
  Json joints = Json::array();
  for (std::size_t i = 0; i < places.size(); ++i) {
    builder.json["nodes"].push_back({{"name", "joint"}, {"matrix", column_major(places[i])}});
    builder.json["scenes"][0]["nodes"].push_back(i + 1);
    joints.push_back(i + 1);
  }
  builder.json["skins"] = {{{"name", "hide"}, {"joints", joints}}};
  if (!binds.empty()) {
    std::vector<float> numbers;
    for (const glm::dmat4& m : binds)
      for (int i = 0; i < 16; ++i) numbers.push_back(static_cast<float>(m[i / 4][i % 4]));
    builder.json["skins"][0]["inverseBindMatrices"] = builder.add("MAT4", kFloat, numbers, binds.size());
  }
  builder.node()["skin"] = 0;
  builder.node()["translation"] = {100, 200, 300};
  Json& attributes = builder.primitive()["attributes"];
  attributes["JOINTS_0"] =
      builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>{0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}, 3);
  attributes["WEIGHTS_0"] =
      builder.add("VEC4", kFloat, std::vector<float>{1, 0, 0, 0, 0.25F, 0.75F, 0, 0, 1, 0, 0, 0}, 3);
  attributes["NORMAL"] = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  return builder;
}

glm::dvec3 world(const Scene& scene, std::size_t vertex) {
  const auto& node = scene.nodes.at(0);
  const Primitive& primitive = scene.meshes.at(node.mesh).primitives.at(0);
  return glm::dvec3(node.world_from_object * glm::dvec4(primitive.positions_object.at(vertex), 1));
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double within = 1e-5) {
  EXPECT_LT(glm::length(a - b), within) << a.x << " " << a.y << " " << a.z << ", not " << b.x << " " << b.y << " "
                                        << b.z;
}

const glm::dvec4 kCorners[] = {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}};

TEST(SceneSkin, vertices_are_the_mean_of_what_their_joints_make_of_them) {
  const Matrices places{turned(30, {1, 2, 1}, {1, 2, 3}), turned(-70, {2, 1, 3}, {-4, 0, 1})};
  const Matrices binds{turned(10, {1, 1, 1}, {0.5, 0, 0}), turned(0, {1, 1, 2}, {0, -0.25, 0})};
  const Scene scene = skinned(places, binds).load();
  const glm::dmat4 a = places[0] * binds[0], b = places[1] * binds[1];
  expect_near(world(scene, 0), glm::dvec3(a * kCorners[0]));
  expect_near(world(scene, 1), 0.25 * glm::dvec3(a * kCorners[1]) + 0.75 * glm::dvec3(b * kCorners[1]));
  expect_near(world(scene, 2), glm::dvec3(b * kCorners[2]));
  EXPECT_EQ(scene.nodes.at(0).world_from_object, glm::dmat4(1.0));
  EXPECT_TRUE(scene.warnings.empty() && scene.unsupported.empty());
  ASSERT_EQ(scene.skins.size(), 1U);
  EXPECT_EQ(scene.skins[0].name, "hide");
  EXPECT_EQ(scene.skins[0].joint_count, 2U);
}

TEST(SceneSkin, normals_and_tangents_follow_and_stay_unit) {
  // A scale of 2 along x tilts a normal by half of what it tilts tangents.
  Builder builder = skinned({turned(0, {2, 1, 1}), turned(90)});
  Json& attributes = builder.primitive()["attributes"];
  const float s = std::sqrt(0.5F);
  attributes["NORMAL"] = builder.add("VEC3", kFloat, std::vector<float>{s, s, 0, 0, 0, 1, s, s, 0}, 3);
  attributes["TANGENT"] = builder.add("VEC4", kFloat, std::vector<float>{s, -s, 0, -1, 1, 0, 0, 1, s, -s, 0, 1}, 3);
  attributes["TEXCOORD_0"] = builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  builder.json["images"] = {
      {{"uri",
        "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAA"
        "AABJRU5ErkJggg=="}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["normalTexture"] = {{"index", 0}};
  const Scene scene = builder.load();
  const Primitive& primitive = scene.meshes.at(0).primitives.at(0);
  expect_near(primitive.normals_object.at(0), glm::normalize(glm::dvec3(1, 2, 0)));
  expect_near(glm::dvec3(primitive.tangents_object.at(0)), glm::normalize(glm::dvec3(2, -1, 0)));
  EXPECT_EQ(primitive.tangents_object.at(0).w, -1);
  expect_near(primitive.normals_object.at(2), glm::dvec3(-s, s, 0));
  expect_near(glm::dvec3(primitive.tangents_object.at(2)), glm::dvec3(s, s, 0));
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

TEST(SceneSkin, a_skin_of_one_joint_is_a_mesh_at_that_place) {
  for (const double x : {1.0, -1.0}) {  // the second one mirrors
    const glm::dmat4 place = turned(40, {x, 1.5, 2}, {3, 2, 1});
    Builder rigid = skinned({place});
    rigid.primitive()["attributes"].erase("JOINTS_0");
    rigid.primitive()["attributes"].erase("WEIGHTS_0");
    rigid.node() = {{"name", "triangle"}, {"mesh", 0}, {"matrix", column_major(place)}};
    Builder soft = skinned({place});
    soft.primitive()["attributes"]["JOINTS_0"] = soft.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>(12), 3);
    const Scene a = soft.load(), b = rigid.load();
    EXPECT_EQ(b.nodes.at(0).mirrored, x < 0);
    EXPECT_FALSE(a.nodes.at(0).mirrored);
    EXPECT_EQ(a.meshes.at(0).primitives.at(0).indices, x < 0 ? kTurned : kAsInFile) << "the front stays in front";
    for (std::size_t i = 0; i < 3; ++i) expect_near(world(a, i), world(b, i));
    // A normal is turned by the cofactors, and against the place's mirror.
    const auto normal = [](const Scene& scene) {
      const glm::dmat3 m(scene.nodes.at(0).world_from_object);
      const glm::dvec3 n(scene.meshes.at(0).primitives.at(0).normals_object.at(0));
      const glm::dvec3 turned = glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])) * n;
      return glm::normalize(scene.nodes.at(0).mirrored ? -turned : turned);
    };
    expect_near(normal(a), normal(b));
  }
}

TEST(SceneSkin, joints_that_no_corner_follows_turn_nothing) {
  const glm::dmat4 place = turned(40, {1, 1.5, 2}), mirror = turned(40, {-1, 1.5, 2});
  for (const bool mirrored : {true, false}) {
    Builder builder = skinned({mirrored ? mirror : place, mirrored ? place : mirror, mirrored ? place : mirror});
    builder.primitive()["attributes"]["JOINTS_0"] =
        builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>(12), 3);
    const Primitive read = builder.load().meshes.at(0).primitives.at(0);
    EXPECT_EQ(read.indices, mirrored ? kTurned : kAsInFile);
    expect_near(glm::dvec3(read.normals_object.at(0)), {0, 0, 1});
  }
}

TEST(SceneSkin, each_triangle_faces_as_most_of_its_corners_do) {
  const glm::dmat4 mirror = turned(0, {-1, 1, 1});
  for (const auto& [joints, mirrored] : {std::pair(std::vector<std::uint8_t>{1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, true),
                                         {{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, false}}) {
    Builder builder = skinned({glm::dmat4(1.0), mirror});
    Json& attributes = builder.primitive()["attributes"];
    attributes["JOINTS_0"] = builder.add("VEC4", kUnsignedByte, joints, 3);
    attributes["WEIGHTS_0"] = builder.add("VEC4", kFloat, std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 3);
    EXPECT_EQ(builder.load().meshes.at(0).primitives.at(0).indices, mirrored ? kTurned : kAsInFile);
  }
}

TEST(SceneSkin, eight_weights_of_every_type_count) {
  Matrices places;
  for (int i = 0; i < 300; ++i) places.push_back(turned(0, glm::dvec3(1), {i, 0, 0}));
  Builder builder = skinned(places);
  Json& attributes = builder.primitive()["attributes"];
  const std::vector<std::uint16_t> joints{256, 299, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8};
  attributes["JOINTS_0"] = attributes["JOINTS_1"] = builder.add("VEC4", kUnsignedShort, joints, 3);
  const auto normalized = [&](std::size_t accessor) {
    builder.json["accessors"][accessor]["normalized"] = true;
    return accessor;
  };
  attributes["WEIGHTS_0"] = normalized(
      builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>{51, 51, 0, 0, 255, 0, 0, 0, 0, 0, 0, 51}, 3));
  attributes["WEIGHTS_1"] = normalized(
      builder.add("VEC4", kUnsignedShort, std::vector<std::uint16_t>{39321, 0, 0, 0, 0, 0, 0, 0, 52428, 0, 0, 0}, 3));
  const Scene scene = builder.load();
  EXPECT_NEAR(world(scene, 0).x, 0.2 * 256 + 0.2 * 299 + 0.6 * 256, 1e-4);
  EXPECT_NEAR(world(scene, 1).x, 1 + 1, 1e-6);
  EXPECT_NEAR(world(scene, 2).x, 0.2 * 8 + 0.8 * 5, 1e-5);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

TEST(SceneSkin, joints_move_with_animations_wherever_they_stand) {
  Builder builder = skinned({glm::dmat4(1.0), glm::dmat4(1.0)});
  builder.json["nodes"][1] = {{"name", "upper"}, {"translation", {0, 1, 0}}, {"children", {2}}};
  builder.json["nodes"][2] = {{"name", "lower"}, {"translation", {0, 1, 0}}};
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const float half = std::sqrt(0.5F);
  add_channel(builder, 0, target_of(1, "rotation"),
              {.times = {0, 1}, .values = {0, 0, 0, 1, 0, 0, half, half}, .type = "VEC4"});
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 50, 50, 50}});
  const Scene scene = load_at(builder, 1);
  expect_near(world(scene, 0), {0, 1, 0});
  // (0, 1, 0) in the space of the lower joint, which lies at (-1, 1, 0) and is turned by 90
  // degrees.
  expect_near(world(scene, 2), {-2, 1, 0});
  EXPECT_NE(scene.hash, load_at(builder, 0.5).hash);
}

TEST(SceneSkin, morph_targets_come_before_joints) {
  Builder builder = skinned({turned(90), turned(90)});
  const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0}, 3);
  builder.primitive()["targets"] = {{{"POSITION", up}}};
  builder.node()["weights"] = {2};
  expect_near(world(builder.load(), 0), {0, 2, 0});
}

TEST(SceneSkin, one_mesh_with_and_without_skins_is_several) {
  Builder builder = skinned({turned(90), turned(90)});
  builder.json["skins"].push_back({{"joints", {2, 1}}});
  builder.json["nodes"].push_back({{"mesh", 0}});
  builder.json["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  builder.json["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
  for (const int node : {3, 4, 5}) builder.json["scenes"][0]["nodes"].push_back(node);
  const Scene scene = builder.load();
  ASSERT_EQ(scene.meshes.size(), 3U);
  EXPECT_EQ(scene.nodes.at(0).mesh, scene.nodes.at(3).mesh);
  EXPECT_EQ(scene.meshes[scene.nodes.at(1).mesh].primitives.at(0).positions_object.at(1), glm::vec3(1, 0, 0));
}

TEST(SceneSkin, weights_are_normalised_and_said) {
  struct Row {
    std::vector<float> first;  // weights of corner 0 for joints 0 and 1, at x = 10 and 20
    double x;
    const char* says;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Row& row : {Row{{0.5F, 0}, 10, "element 0 does not sum to 1 (1 of them)"}, Row{{2, 6}, 17.5, "normalised"},
                         Row{{0, 0}, 10, "does not sum to 1"}, Row{{nan, 1}, 20, "no number (1 of them)"},
                         Row{{-1, 1}, 20, "has a negative one"}, Row{{0.5F, 0.4999F}, 14.999, ""}}) {
    Builder builder = skinned({turned(0, glm::dvec3(1), {10, 0, 0}), turned(0, glm::dvec3(1), {20, 0, 0})});
    Json& attributes = builder.primitive()["attributes"];
    attributes["JOINTS_0"] =
        builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 3);
    attributes["WEIGHTS_0"] =
        builder.add("VEC4", kFloat, std::vector<float>{row.first[0], row.first[1], 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 3);
    const Scene scene = builder.load();
    EXPECT_NEAR(world(scene, 0).x, row.x, 1e-3) << row.says;
    EXPECT_EQ(scene.out_of_range.empty(), std::string(row.says).empty());
    if (!scene.out_of_range.empty()) {
      EXPECT_TRUE(warns(scene, row.says)) << scene.warnings[0];
    }
  }
}

TEST(SceneSkin, what_is_wrong_with_a_skin_is_said_in_a_line) {
  struct Row {
    std::function<void(Builder&)> damage;
    const char* says;
  };
  const auto attribute = [](const char* name, auto values, int component) {
    return [=](Builder& b) { b.primitive()["attributes"][name] = b.add("VEC4", component, values, values.size() / 4); };
  };
  const std::vector<std::uint8_t> far_joint{0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0};
  const std::vector<Row> rows{
      {attribute("JOINTS_0", far_joint, kUnsignedByte), "element 1 names joint 7, but skin 'hide' has 2"},
      {attribute("JOINTS_0", std::vector<std::uint8_t>(8), kUnsignedByte), "has 2 elements for 3 positions"},
      {attribute("JOINTS_0", std::vector<float>(12), kFloat), "JOINTS_0 in accessor"},
      {attribute("WEIGHTS_0", std::vector<std::uint8_t>(12), kUnsignedByte), "WEIGHTS_0 in accessor"},
      {[](Builder& b) { b.primitive()["attributes"].erase("WEIGHTS_0"); }, "has JOINTS_0 without WEIGHTS_0"},
      {[](Builder& b) { b.json["skins"][0].erase("joints"); }, "skin 'hide': has no 'joints'"},
      {[](Builder& b) { b.json["skins"][0]["joints"] = Json::array(); }, "skin 'hide': has no 'joints'"},
      {[](Builder& b) {
         b.json["skins"][0]["joints"] = {1, 99};
       },
       "skin 'hide'"},
      {[](Builder& b) { b.json["skins"][0]["inverseBindMatrices"] = 0; }, "are not MAT4 of float"},
      {[](Builder& b) { b.json["skins"][0]["inverseBindMatrices"] = b.add("MAT4", kFloat, std::vector<float>(16), 1); },
       "has 2 joints, but 1 inverse bind matrices"},
      {[](Builder& b) {
         std::vector<float> numbers(32, 1.0F);
         numbers[17] = std::numeric_limits<float>::infinity();
         b.json["skins"][0]["inverseBindMatrices"] = b.add("MAT4", kFloat, numbers, 2);
       },
       "inverse bind matrix 1 in"},
      {[](Builder& b) { b.json["nodes"][1]["children"] = {1}; }, "NODE_LOOP"},
      {[](Builder& b) {
         b.json["nodes"][1]["children"] = {2};
         b.json["nodes"][2]["children"] = {1};
       },
       "NODE_LOOP"},
      {[](Builder& b) {
         b.json["nodes"][1].erase("matrix");
         b.json["nodes"][1]["scale"] = {1e20, 1, 1};
       },
       "beyond 2^40 m"}};
  for (const Row& row : rows) {
    Builder builder = skinned({turned(0), turned(0)});
    row.damage(builder);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, row.says));
  }
}

TEST(SceneSkin, joints_out_of_range_without_weight_do_not_count) {
  Builder builder = skinned({turned(0), turned(0)});
  builder.primitive()["attributes"]["JOINTS_0"] =
      builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>{0, 0, 99, 99, 0, 1, 99, 99, 0, 0, 0, 99}, 3);
  EXPECT_TRUE(builder.load().warnings.empty());
}

TEST(SceneSkin, what_has_a_meaning_is_mended) {
  struct Row {
    std::function<void(Builder&)> change;
    const char* says;
    glm::dvec3 corner;
  };
  const std::vector<Row> rows{{[](Builder& b) { b.json["scenes"][0]["nodes"] = {0}; },
                               "its joint node 'joint' is not in the scene; it stands where its own parents put it",
                               {5, 0, 0}},
                              {[](Builder& b) {
                                 b.primitive()["attributes"].erase("JOINTS_0");
                                 b.primitive()["attributes"].erase("WEIGHTS_0");
                               },
                               "node 'triangle': has a skin, but its mesh 'flat' has no JOINTS_0",
                               {100, 200, 300}},
                              {[](Builder& b) {
                                 std::vector<float> numbers;
                                 for (int i = 0; i < 32; ++i) numbers.push_back(i % 16 % 5 == 0 ? 1.0F : 0.0F);
                                 numbers[3] = 0.5F;
                                 b.json["skins"][0]["inverseBindMatrices"] = b.add("MAT4", kFloat, numbers, 2);
                               },
                               "the last row of inverse bind matrix 0 is not 0 0 0 1",
                               {5, 0, 0}},
                              {[](Builder& b) {
                                 Json rigid = b.primitive();
                                 rigid["attributes"].erase("JOINTS_0");
                                 b.json["meshes"][0]["primitives"].push_back(rigid);
                               },
                               "primitive 1: left out, it has no JOINTS_0",
                               {5, 0, 0}}};
  for (const Row& row : rows) {
    Builder builder = skinned({turned(0, glm::dvec3(1), {5, 0, 0}), turned(0, glm::dvec3(1), {5, 0, 0})});
    row.change(builder);
    const Scene scene = builder.load();
    ASSERT_EQ(scene.out_of_range.size(), 1U) << row.says;
    EXPECT_TRUE(contains(scene.out_of_range[0], row.says));
    expect_near(world(scene, 0), row.corner);
    EXPECT_EQ(scene.meshes.at(0).primitives.size(), 1U);
  }
}

/// The triangle at joints 1 and 2, which the scene does not list and which stand at x = 5.
Builder with_joints_outside() {
  Builder builder = skinned({turned(0, glm::dvec3(1), {5, 0, 0}), turned(0, glm::dvec3(1), {5, 0, 0})});
  builder.json["scenes"][0]["nodes"] = {0};
  return builder;
}

TEST(SceneSkin, of_nodes_outside_of_the_scene_only_those_above_joints_have_to_be_right) {
  const std::vector<std::pair<Json, const char*>> rows{
      {{{"name", "bad"}, {"rotation", {0, 0, 0, 0}}}, "node 'bad': rotation (0, 0, 0, 0)"},
      {{{"name", "bad"}, {"matrix", Json(std::vector<double>(16, 1))}}, "node 'bad': the last row of its matrix"},
      {{{"name", "bad"}, {"matrix", {1e308, 0, 0, 0, 1e308, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}, "together overflow"},
      {{{"name", "bad"}, {"mesh", 99}}, "node 'bad': 'mesh' names mesh 99"}};
  for (const auto& [bad, says] : rows) {
    Builder builder = with_joints_outside();
    builder.json["nodes"].push_back(bad);
    Json big = column_major(turned(0));
    big[0] = 1e308, big[1] = 1e308;
    builder.json["nodes"].push_back({{"name", "below"}, {"matrix", big}});
    builder.json["nodes"][3]["children"] = {4};
    expect_near(world(builder.load(), 0), {5, 0, 0});
    builder.json["nodes"][4]["children"] = {1};
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, says));
  }
}

TEST(SceneSkin, a_joint_of_several_parents_outside_of_the_scene_stands_under_the_first) {
  Builder builder = with_joints_outside();
  builder.json["nodes"].push_back({{"translation", {0, 1, 0}}, {"children", {1}}});
  builder.json["nodes"].push_back({{"translation", {0, 2, 0}}, {"children", {1, 5}}});
  builder.json["nodes"].push_back({{"translation", {0, 4, 0}}, {"children", {2, 1}}});
  const Scene scene = builder.load();
  expect_near(world(scene, 0), {5, 1, 0});
  expect_near(world(scene, 2), {5, 7, 0});
}

}  // namespace
