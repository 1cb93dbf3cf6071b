// SPDX-License-Identifier: Apache-2.0
// EXT_mesh_gpu_instancing: where the instances of a mesh stand, and files that say it badly.
#include <cmath>
#include <limits>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kByte;
using scene_test::kFloat;
using scene_test::message_of;

/// The builder's triangle with attributes of the extension, which is required.
struct Instanced : Builder {
  Json& attributes() { return node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]; }
  Instanced() {
    json["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
    json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  }
  Instanced& with(const char* name, const char* type, const std::vector<float>& values, std::size_t count) {
    attributes()[name] = add(type, kFloat, values, count);
    return *this;
  }
};

glm::dvec3 corner(const Scene& scene, std::size_t node, std::size_t vertex) {
  const glm::vec3 p = scene.meshes.at(scene.nodes.at(node).mesh).primitives.at(0).positions_object.at(vertex);
  return glm::dvec3(scene.nodes.at(node).world_from_object * glm::dvec4(p, 1.0));
}

TEST(SceneInstances, each_is_scaled_turned_and_moved_before_its_node) {
  Instanced file;
  const float half = std::sqrt(0.5F);
  file.with("TRANSLATION", "VEC3", {1, 2, 3, 0, 0, 0}, 2).with("SCALE", "VEC3", {2, 3, 4, 1, 1, -1}, 2);
  file.with("ROTATION", "VEC4", {0, 0, half, half, 0, 0, 0, 1}, 2);
  file.attributes()["_ID"] = file.add("SCALAR", kFloat, std::vector<float>{7, 8}, 2);  // the application's own
  file.node()["translation"] = {100, 0, 0};
  const Scene scene = file.load();
  ASSERT_EQ(scene.nodes.size(), 2U);
  ASSERT_EQ(scene.meshes.size(), 1U);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(corner(scene, 0, 1), glm::dvec3(101, 4, 3));  // (1, 0, 0): twice as long, a quarter turn about z, moved
  EXPECT_EQ(corner(scene, 0, 2), glm::dvec3(98, 2, 3));   // (0, 1, 0)
  EXPECT_EQ(corner(scene, 1, 1), glm::dvec3(101, 0, 0));
  EXPECT_FALSE(scene.nodes[0].mirrored);
  EXPECT_TRUE(scene.nodes[1].mirrored);
  EXPECT_EQ(scene.nodes[0].name, "triangle");
}

TEST(SceneInstances, rotations_may_be_normalized_integers) {
  Instanced file;
  const std::size_t turns = file.add("VEC4", kByte, std::vector<std::int8_t>{0, 0, 127, 127, 0, 127, 0, 0}, 2);
  file.json["accessors"][turns]["normalized"] = true;
  file.attributes()["ROTATION"] = turns;
  const Scene scene = file.load();
  EXPECT_EQ(corner(scene, 0, 1), glm::dvec3(0, 1, 0));
  EXPECT_EQ(corner(scene, 1, 1), glm::dvec3(-1, 0, 0));
}

TEST(SceneInstances, no_element_is_no_instance_and_other_nodes_stay) {
  Instanced file;
  file.with("TRANSLATION", "VEC3", {0, 0, 0}, 1);
  file.json["nodes"].push_back({{"name", "plain"}, {"mesh", 0}});
  file.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(file.load().nodes.size(), 2U);
}

TEST(SceneInstances, a_node_without_a_mesh_has_nothing_to_repeat) {
  Instanced file;
  file.with("TRANSLATION", "VEC3", {0, 0, 0}, 1);
  file.node().erase("mesh");
  const Scene scene = file.load();
  EXPECT_TRUE(scene.nodes.empty());
  EXPECT_TRUE(scene_test::warns(scene, "node 'triangle': its instances are of no mesh"));
  Instanced turned;
  turned.with("ROTATION", "VEC4", {0, 0, 0, 0}, 1);
  turned.node().erase("mesh");
  EXPECT_TRUE(turned.load().nodes.empty()) << "what is left out is not read";
}

TEST(SceneInstances, bad_ones_are_refused_with_their_place) {
  const auto message = [](const Instanced& file) { return message_of([&] { (void)file.load(); }); };
  Instanced counts;
  counts.with("TRANSLATION", "VEC3", {0, 0, 0, 1, 1, 1}, 2).with("SCALE", "VEC3", {1, 1, 1}, 1);
  EXPECT_TRUE(contains(message(counts), "each instance needs one of every attribute"));

  Instanced type;
  type.with("TRANSLATION", "VEC4", {0, 0, 0, 0}, 1);
  EXPECT_TRUE(contains(message(type), "node 'triangle'"));
  EXPECT_TRUE(contains(message(type), "TRANSLATION in accessor 2 is not VEC3 of floats"));

  Instanced zero;
  zero.with("ROTATION", "VEC4", {0, 0, 0, 1, 0, 0, 0, 0}, 2);
  EXPECT_TRUE(contains(message(zero), "element 1, is (0, 0, 0, 0), which is no rotation"));

  Instanced infinite;
  infinite.with("SCALE", "VEC3", {1, 1, std::numeric_limits<float>::infinity()}, 1);
  EXPECT_TRUE(contains(message(infinite), "SCALE in accessor 2, element 0, is not finite"));

  Instanced far;
  far.with("TRANSLATION", "VEC3", {0, 0, 0, 1e30F, 0, 0}, 2);
  EXPECT_TRUE(contains(message(far), "beyond 2^40 m"));

  Instanced overflow;
  overflow.with("SCALE", "VEC3", {1e30F, 1e30F, 1e30F}, 1);
  overflow.node()["scale"] = {1e300, 1, 1};
  EXPECT_TRUE(contains(message(overflow), "overflow"));

  Instanced missing;
  missing.attributes()["SCALE"] = 99;
  EXPECT_TRUE(contains(message(missing), "'SCALE' is not one of the"));

  Instanced empty;
  empty.node()["extensions"]["EXT_mesh_gpu_instancing"] = Json::object();
  EXPECT_TRUE(contains(message(empty), "'attributes' is missing or empty"));

  // A file of a few bytes that would place 2^32 meshes.
  Instanced endless;
  endless.json["accessors"].push_back({{"componentType", kFloat}, {"count", 4294967295U}, {"type", "VEC3"}});
  endless.attributes()["TRANSLATION"] = endless.json["accessors"].size() - 1;
  EXPECT_TRUE(contains(message(endless), "elements of zeros without a bufferView"));
}

}  // namespace
