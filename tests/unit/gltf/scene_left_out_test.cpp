// SPDX-License-Identifier: Apache-2.0
// Whatever is left out is said once, with its user; what changes nothing is not.
#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::leaves_out;

TEST(SceneMaterials, what_is_left_out_is_named_unless_it_changes_nothing) {
  EXPECT_TRUE(Builder().load().unsupported.empty());
  Builder builder;
  builder.material()["name"] = "rich";
  builder.material()["extensions"] = {{"KHR_materials_volume_scatter", Json::object()},
                                      {"KHR_materials_subsurface", Json::object()},
                                      {"VENDOR_\nunheard_of", Json::object()}};
  const Scene scene = builder.load();
  for (const char* feature : {"KHR_materials_volume_scatter", "KHR_materials_subsurface", "VENDOR_ unheard_of"}) {
    EXPECT_TRUE(leaves_out(scene, feature, "material 'rich'")) << feature;
  }
  EXPECT_EQ(scene.unsupported.size(), 3U);
  builder.material()["extensions"] = {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0}}},
                                      {"KHR_materials_sheen", {{"sheenColorFactor", {0, 0, 0}}}},
                                      {"KHR_materials_dispersion", {{"dispersion", 0}}},
                                      {"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 0}}},
                                      {"KHR_materials_iridescence", {{"iridescenceIor", 1.4}}}};
  EXPECT_TRUE(builder.load().unsupported.empty());
}

TEST(SceneMaterials, a_feature_is_named_once_with_its_first_user_and_the_number_of_others) {
  Builder builder;
  for (int i = 0; i < 3; ++i) {
    builder.json["materials"].push_back(
        {{"name", "paint" + std::to_string(i)}, {"extensions", {{"VENDOR_paint", Json::object()}}}});
    Json primitive = builder.primitive();
    primitive["material"] = i + 1;
    builder.json["meshes"][0]["primitives"].push_back(primitive);
  }
  const Scene scene = builder.load();
  ASSERT_EQ(scene.unsupported.size(), 1U);
  EXPECT_EQ(scene.unsupported[0].user, "material 'paint0' and 2 more");
}

TEST(SceneMaterials, materials_that_nothing_uses_keep_their_number_and_ask_for_nothing) {
  Builder builder;
  builder.json["materials"].push_back({{"name", "coat"}, {"extensions", {{"VENDOR_paint", Json::object()}}}});
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.size(), 2U);
  EXPECT_TRUE(scene.unsupported.empty());
}

TEST(SceneMaterials, a_node_without_a_name_is_called_by_its_number_in_the_file) {
  Builder builder;
  builder.json["nodes"].insert(builder.json["nodes"].begin(), Json::object());
  builder.json["nodes"][1].erase("name");
  builder.json["scenes"][0]["nodes"] = {1};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.nodes.size(), 1U);
  EXPECT_EQ(scene.nodes[0].name, "node 1");
}

TEST(SceneMaterials, features_outside_materials_are_named_with_their_owner) {
  Builder builder;
  builder.json["extensions"] = {{"ACME_weather", {{"rain", 1}}}};
  builder.primitive()["attributes"]["COLOR_1"] = 0;
  builder.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const Scene scene = builder.load();
  EXPECT_TRUE(leaves_out(scene, "ACME_weather", "the document"));
  EXPECT_TRUE(leaves_out(scene, "vertex colours COLOR_1", "mesh 'flat'"));
  EXPECT_TRUE(leaves_out(scene, "primitives of mode LINES", "mesh 'flat'"));
  EXPECT_EQ(scene.unsupported.size(), 3U);
  EXPECT_EQ(scene.meshes.at(0).primitives.size(), 1U);
}

TEST(SceneMaterials, texture_coordinates_alone_are_harmless) {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] = builder.add("VEC2", kFloat, std::vector<float>(6), 3);
  builder.primitive()["attributes"]["TANGENT"] = builder.add("VEC4", kFloat, std::vector<float>(12), 3);
  EXPECT_TRUE(builder.load().unsupported.empty());
}

}  // namespace
