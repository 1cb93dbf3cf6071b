// SPDX-License-Identifier: Apache-2.0
// Morph targets at the weights of the file: what they change, what they cost, and weights that do
// not fit.
#include <algorithm>
#include <cmath>
#include <functional>

#include "support/gltf_builder.h"

namespace {

using eikon::Primitive;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kByte;
using scene_test::kFloat;
using scene_test::kShort;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedShort;
using scene_test::message_of;

/// The triangle with a target that moves its vertices by (0, 0, 1), (0, 0, 2), (0, 0, 3), and one
/// by (2, 0, 0) each.
Builder morphing() {
  Builder builder;
  const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 2, 0, 0, 3}, 3),
                    aside = builder.add("VEC3", kFloat, std::vector<float>{2, 0, 0, 2, 0, 0, 2, 0, 0}, 3);
  builder.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  return builder;
}

std::vector<glm::vec3> positions(const Scene& scene, std::size_t mesh = 0) {
  return scene.meshes.at(mesh).primitives.at(0).positions_object;
}

/// An accessor without a bufferView, whose element `at` is replaced.
std::size_t add_sparse(Builder& builder, std::uint8_t at, const std::vector<float>& value) {
  const std::size_t indices = builder.add_view(std::vector<std::uint8_t>{at}), values = builder.add_view(value);
  builder.json["accessors"].push_back({{"componentType", kFloat},
                                       {"count", 3},
                                       {"type", "VEC3"},
                                       {"sparse",
                                        {{"count", 1},
                                         {"indices", {{"bufferView", indices}, {"componentType", kUnsignedByte}}},
                                         {"values", {{"bufferView", values}}}}}});
  return builder.json["accessors"].size() - 1;
}

TEST(SceneMorph, weights_of_the_node_count_before_those_of_the_mesh) {
  using Values = std::vector<glm::vec3>;
  Builder builder = morphing();
  const Values still{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(positions(builder.load()), still);
  builder.json["meshes"][0]["weights"] = {0.5, 0};
  EXPECT_EQ(positions(builder.load()), (Values{{0, 0, 0.5}, {1, 0, 1}, {0, 1, 1.5}}));
  builder.node()["weights"] = {0, -1};
  EXPECT_EQ(positions(builder.load()), (Values{{-2, 0, 0}, {-1, 0, 0}, {-2, 1, 0}}));
  builder.node()["weights"] = {1, 2};
  EXPECT_EQ(positions(builder.load()), (Values{{4, 0, 1}, {5, 0, 2}, {4, 1, 3}}));
  builder.node()["weights"] = {0, 0};
  const Scene zero = builder.load();
  EXPECT_EQ(positions(zero), still);
  EXPECT_TRUE(zero.warnings.empty() && zero.unsupported.empty());
}

TEST(SceneMorph, one_mesh_under_nodes_of_different_weights_is_several) {
  Builder builder = morphing();
  builder.json["nodes"] = {{{"mesh", 0}},
                           {{"mesh", 0}, {"weights", {1, 0}}},
                           {{"mesh", 0}, {"weights", {1, 0}}},
                           {{"mesh", 0}, {"weights", {0, 0}}}};
  builder.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.meshes.size(), 2U);
  EXPECT_EQ(scene.nodes.at(0).mesh, 0U);
  EXPECT_EQ(scene.nodes.at(1).mesh, 1U);
  EXPECT_EQ(scene.nodes.at(2).mesh, 1U);
  EXPECT_EQ(scene.nodes.at(3).mesh, 0U);
  EXPECT_EQ(positions(scene, 1)[2], glm::vec3(0, 1, 3));
}

TEST(SceneMorph, normals_colours_tangents_and_texture_coordinates_change_too) {
  Builder builder;
  Json& attributes = builder.primitive()["attributes"];
  attributes["NORMAL"] = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  attributes["COLOR_0"] = builder.add("VEC4", kFloat, std::vector<float>(12, 0.5F), 3);
  attributes["TEXCOORD_0"] = builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  attributes["TANGENT"] = builder.add("VEC4", kFloat, std::vector<float>{1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, 3);
  builder.json["images"] = {
      {{"uri",
        "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAA"
        "AABJRU5ErkJggg=="}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["normalTexture"] = {{"index", 0}};
  Json target;
  target["NORMAL"] = builder.add("VEC3", kFloat, std::vector<float>{2, 0, 0, 0, 0, 0, 0, 0, 0}, 3);
  target["COLOR_0"] = builder.add("VEC4", kFloat, std::vector<float>{0.5F, 0, 0, -0.5F, 0, 0, 0, 0, 0, 0, 0, 0}, 3);
  target["TEXCOORD_0"] = builder.add("VEC2", kFloat, std::vector<float>{0, 0, 8, 0, 0, 0}, 3);
  target["TANGENT"] = builder.add("VEC3", kFloat, std::vector<float>{0, 2, 0, 0, 0, 0, 0, 0, 0}, 3);
  builder.primitive()["targets"] = {target};
  builder.json["meshes"][0]["weights"] = {0.5};
  const Scene scene = builder.load();
  const Primitive& primitive = scene.meshes.at(0).primitives.at(0);
  EXPECT_LT(glm::length(primitive.normals_object.at(0) - glm::vec3(std::sqrt(0.5F), 0, std::sqrt(0.5F))), 1e-6F);
  EXPECT_EQ(primitive.normals_object.at(1), glm::vec3(0, 0, 1));
  EXPECT_EQ(primitive.colors.at(0), glm::vec4(0.75F, 0.5F, 0.5F, 0.25F));
  EXPECT_EQ(primitive.colors.at(1), glm::vec4(0.5F));
  EXPECT_EQ(primitive.uv[0].at(1), glm::vec2(5, 0));
  const glm::vec4 tangent = primitive.tangents_object.at(0);
  EXPECT_LT(glm::length(glm::vec3(tangent) - glm::vec3(std::sqrt(0.5F), std::sqrt(0.5F), 0)), 1e-6F);
  EXPECT_EQ(tangent.w, -1.0F);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

TEST(SceneMorph, hundreds_of_sparse_targets_add_up) {
  Builder builder;
  Json targets = Json::array(), weights = Json::array();
  for (std::uint8_t t = 0; t < 200; ++t) {
    targets.push_back({{"POSITION", add_sparse(builder, t % 3, {0, 0, static_cast<float>(t)})}});
    weights.push_back(t % 2 == 0 ? 0.5 : 0.0);
  }
  builder.primitive()["targets"] = targets;
  builder.json["meshes"][0]["weights"] = weights;
  glm::vec3 want(0.0F);
  for (int t = 0; t < 200; t += 2) want[t % 3] += 0.5F * static_cast<float>(t);
  const std::vector<glm::vec3> read = positions(builder.load());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read.at(static_cast<std::size_t>(i)).z, want[i]);
}

TEST(SceneMorph, sparse_elements_are_found_beyond_the_first_block) {
  constexpr std::size_t kCount = 10000;
  Builder builder;
  std::vector<float> points(3 * kCount);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<float>(i % 7);
  builder.primitive() = {{"attributes", {{"POSITION", builder.add("VEC3", kFloat, points, kCount)}}}};
  const std::vector<std::uint16_t> at{0, 4095, 4096, 9998};
  const std::size_t indices = builder.add_view(at), values = builder.add_view(std::vector<float>(12, 1.0F));
  builder.json["accessors"].push_back({{"componentType", kFloat},
                                       {"count", kCount},
                                       {"type", "VEC3"},
                                       {"sparse",
                                        {{"count", 4},
                                         {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
                                         {"values", {{"bufferView", values}}}}}});
  builder.primitive()["targets"] = {{{"POSITION", builder.json["accessors"].size() - 1}}};
  builder.json["meshes"][0]["weights"] = {10};
  const std::vector<glm::vec3> read = positions(builder.load());
  ASSERT_EQ(read.size(), kCount - 1);  // of whole triangles
  for (std::size_t i = 0; i < read.size(); ++i) {
    const bool moved = std::find(at.begin(), at.end(), i) != at.end();
    EXPECT_EQ(read[i].x, points[3 * i] + (moved ? 10 : 0)) << i;
  }
}

TEST(SceneMorph, quantised_targets_and_bases_are_read_in_their_own_scales) {
  Builder builder;
  builder.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  builder.primitive()["attributes"]["POSITION"] =
      builder.add("VEC3", kShort, std::vector<std::int16_t>{0, 0, 0, 10, 0, 0, 0, 10, 0}, 3);
  const std::size_t target = builder.add("VEC3", kByte, std::vector<std::int8_t>{0, 0, 127, 0, 0, -127, 0, 0, 0}, 3);
  builder.json["accessors"][target]["normalized"] = true;
  builder.primitive()["targets"] = {{{"POSITION", target}}};
  builder.json["meshes"][0]["weights"] = {4};
  EXPECT_EQ(positions(builder.load()), (std::vector<glm::vec3>{{0, 0, 4}, {10, 0, -4}, {0, 10, 0}}));
}

struct MorphRefusal {
  const char* name;
  std::function<void(Builder&)> apply;
  const char* says;
};

TEST(SceneMorph, weights_and_targets_that_do_not_fit_are_refused_in_one_line) {
  const std::vector<MorphRefusal> refusals{
      {"too few weights", [](Builder& b) { b.json["meshes"][0]["weights"] = {1}; },
       "mesh 'flat': 1 weights for the 2 morph targets of mesh 'flat', primitive 0"},
      {"too many weights of a node",
       [](Builder& b) {
         b.node()["weights"] = {1, 2, 3};
       },
       "node 'triangle': 3 weights for the 2 morph targets"},
      {"a primitive without targets",
       [](Builder& b) {
         b.node()["weights"] = {1, 2};
         Json other = b.primitive();
         other.erase("targets");
         b.json["meshes"][0]["primitives"].push_back(other);
       },
       "2 weights for the 0 morph targets of mesh 'flat', primitive 1"},
      {"weights of text",
       [](Builder& b) {
         b.node()["weights"] = {"1", 2};
       },
       "'weights'"},
      {"weights of no list", [](Builder& b) { b.json["meshes"][0]["weights"] = 1; }, "'weights' is not an array"},
      {"elements that are too few",
       [](Builder& b) {
         b.node()["weights"] = {1, 2};
         b.json["accessors"][2]["count"] = 2;
       },
       "has 2 elements for 3 vertices"},
      {"differences of VEC2",
       [](Builder& b) {
         b.node()["weights"] = {1, 2};
         b.json["accessors"][2]["type"] = "VEC2";
       },
       "of a type that glTF does not allow"},
      {"shorts without the extension",
       [](Builder& b) {
         b.node()["weights"] = {1, 2};
         b.json["accessors"][2]["componentType"] = kShort;
       },
       "of a type that glTF does not allow"},
      {"a place beyond all measure",
       [](Builder& b) {
         b.node()["weights"] = {1e300, 2};
       },
       "is not finite"},
      {"an accessor that is wrong",
       [](Builder& b) {
         b.node()["weights"] = {1, 2};
         b.json["accessors"][2]["count"] = 4;
       },
       "accessor 2: 4 elements"}};
  for (const MorphRefusal& refusal : refusals) {
    SCOPED_TRACE(refusal.name);
    Builder builder = morphing();
    refusal.apply(builder);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, refusal.says));
  }
}

TEST(SceneMorph, zeros_that_are_too_many_change_nothing_and_are_said) {
  Builder builder = morphing();
  builder.node()["weights"] = {0, 0, 0};
  const Scene scene = builder.load();
  EXPECT_EQ(positions(scene)[2], glm::vec3(0, 1, 0));
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "all are 0"));
}

TEST(SceneMorph, targets_of_an_attribute_that_the_mesh_lacks_are_left_out_and_said) {
  Builder builder = morphing();
  builder.primitive()["targets"][0]["NORMAL"] = 2;
  builder.node()["weights"] = {1, 0};
  const Scene scene = builder.load();
  EXPECT_EQ(positions(scene)[2], glm::vec3(0, 1, 3));
  EXPECT_TRUE(contains(scene.out_of_range.at(0), "its morph targets change NORMAL, which it lacks"));
}

TEST(SceneMorph, one_accessor_for_countless_targets_is_refused_before_it_is_read) {
  Builder builder;
  const std::size_t count = 60000;
  const std::size_t shared = builder.add("VEC3", kFloat, std::vector<float>(3 * count), count);
  Json targets = Json::array(), weights = Json::array();
  for (int t = 0; t < 3000; ++t) {
    targets.push_back({{"POSITION", shared}});
    weights.push_back(1);
  }
  builder.primitive() = {{"attributes", {{"POSITION", shared}}}, {"targets", targets}};
  builder.json["meshes"][0]["weights"] = weights;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "more than the file's"));
}

}  // namespace
