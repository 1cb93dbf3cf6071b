// SPDX-License-Identifier: Apache-2.0
// Materials, and that whatever is left out is said once.
#include "scene_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::Json;
using scene_test::leaves_out;
using scene_test::mentions;
using scene_test::message_of;
using scene_test::warns;

TEST(SceneMaterials, factors_and_extensions_arrive) {
  Builder builder;
  builder.material() = Json::parse(R"({"name": "lamp", "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.25, "roughnessFactor": 0.75},
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5000000000},
                   "KHR_materials_specular": {"specularFactor": 0.5}}})");
  const Scene scene = builder.load();
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.name, "lamp");
  EXPECT_EQ(material.base_color, glm::vec3(0.1F, 0.2F, 0.3F));
  EXPECT_EQ(material.metallic, 0.25F);
  EXPECT_EQ(material.roughness, 0.75F);
  EXPECT_EQ(material.specular, 0.5F);
  EXPECT_EQ(material.emission, glm::vec3(5e9F, 2.5e9F, 0));  // beyond 32 bits, written as an integer
  EXPECT_TRUE(material.double_sided);
}

TEST(SceneMaterials, a_primitive_without_material_gets_the_default_of_gltf) {
  Builder builder;
  builder.primitive().erase("material");
  const Scene scene = builder.load();
  ASSERT_EQ(scene.materials.size(), 2U);
  EXPECT_EQ(scene.meshes.at(0).primitives.at(0).material, 1U);
  EXPECT_EQ(scene.materials[1].base_color, glm::vec3(1));
  EXPECT_EQ(scene.materials[1].metallic, 1.0F);
  EXPECT_TRUE(leaves_out(scene, "metallic reflection", "the default material"));
}

TEST(SceneMaterials, an_empty_material_has_the_defaults_of_gltf) {
  Builder builder;
  builder.material() = Json::object();
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(1));
  EXPECT_EQ(scene.materials.at(0).metallic, 1.0F);
  EXPECT_EQ(scene.materials.at(0).emission, glm::vec3(0));
  EXPECT_FALSE(scene.materials.at(0).double_sided);
  EXPECT_TRUE(leaves_out(scene, "metallic reflection", "material 0"));
}

TEST(SceneMaterials, values_out_of_range_are_clamped_with_a_warning_naming_the_material) {
  Builder builder;
  builder.material()["pbrMetallicRoughness"] = {
      {"baseColorFactor", {1.5, -0.5, 0.5, 1}}, {"metallicFactor", -1}, {"roughnessFactor", 7}};
  builder.material()["emissiveFactor"] = {2, 0, 0};
  builder.material()["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = -3;
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(1, 0, 0.5F));
  EXPECT_EQ(scene.materials.at(0).metallic, 0.0F);
  EXPECT_EQ(scene.materials.at(0).roughness, 1.0F);
  EXPECT_EQ(scene.materials.at(0).emission, glm::vec3(0));
  for (const char* what : {"baseColorFactor 1.5", "baseColorFactor -0.5", "metallicFactor", "roughnessFactor",
                           "emissiveFactor 2", "emissiveStrength -3"}) {
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + what)) << what;
  }
}

TEST(SceneMaterials, emission_beyond_single_precision_is_refused_by_name) {
  Builder builder;
  builder.material()["emissiveFactor"] = {1, 1, 1};
  builder.material()["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1e39;
  EXPECT_TRUE(mentions(message_of([&] { builder.load(); }), "material 'paint': emissiveStrength"));
}

TEST(SceneMaterials, exactly_lambert_leaves_nothing_out_and_everything_else_is_named) {
  EXPECT_TRUE(Builder().load().unsupported.empty());
  Builder builder;
  builder.json["textures"] = {{{"source", 0}}};
  builder.json["images"] = {{{"uri", "../../does/not/matter.png"}}};
  const Json texture = {{"index", 0}};
  builder.material() = {
      {"name", "rich"},
      {"alphaMode", "MASK"},
      {"normalTexture", texture},
      {"occlusionTexture", texture},
      {"emissiveTexture", texture},
      {"pbrMetallicRoughness",
       {{"metallicFactor", 0.5}, {"baseColorTexture", texture}, {"metallicRoughnessTexture", texture}}},
      {"extensions",
       {{"KHR_materials_specular", {{"specularTexture", texture}}},
        {"KHR_materials_transmission", {{"transmissionFactor", 1}}},
        {"KHR_materials_unlit", Json::object()}}}};
  const Scene scene = builder.load();
  for (const char* feature :
       {"alphaMode MASK", "texture normalTexture", "texture occlusionTexture", "texture emissiveTexture",
        "texture baseColorTexture", "texture metallicRoughnessTexture", "texture specularTexture",
        "metallic reflection", "specular reflection", "KHR_materials_transmission", "KHR_materials_unlit"}) {
    EXPECT_TRUE(leaves_out(scene, feature, "material 'rich'")) << feature;
  }
  EXPECT_EQ(scene.unsupported.size(), 11U);
}

TEST(SceneMaterials, a_feature_is_named_once_with_its_first_user_and_the_number_of_others) {
  Builder builder;
  for (int i = 0; i < 3; ++i) {
    builder.json["materials"].push_back({{"name", "metal" + std::to_string(i)}});
    Json primitive = builder.primitive();
    primitive["material"] = i + 1;
    builder.json["meshes"][0]["primitives"].push_back(primitive);
  }
  const Scene scene = builder.load();
  ASSERT_EQ(scene.unsupported.size(), 1U);
  EXPECT_EQ(scene.unsupported[0].user, "material 'metal0' and 2 more");
}

TEST(SceneMaterials, materials_that_nothing_uses_keep_their_number_and_ask_for_nothing) {
  Builder builder;
  builder.json["materials"].push_back({{"name", "metal"}, {"pbrMetallicRoughness", {{"metallicFactor", 1}}}});
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.size(), 2U);
  EXPECT_TRUE(scene.unsupported.empty());
}

TEST(SceneMaterials, features_outside_materials_are_named_with_their_owner) {
  Builder builder;
  builder.json["skins"] = {{{"joints", {0}}}};
  builder.json["animations"] = {{{"name", "walk"},
                                 {"samplers", {{{"input", 0}, {"output", 0}}}},
                                 {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
  builder.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}}}}}},
                                {"KHR_materials_variants", {{"variants", Json::array()}}}};
  builder.node()["extensions"] = {{"KHR_lights_punctual", {{"light", 0}}}};
  builder.node()["skin"] = 0;
  builder.primitive()["attributes"]["COLOR_1"] = 0;
  builder.primitive()["targets"] = {{{"POSITION", 0}}};
  builder.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const Scene scene = builder.load();
  EXPECT_TRUE(leaves_out(scene, "skin", "node 'triangle'"));
  EXPECT_TRUE(leaves_out(scene, "animation", "animation 'walk'"));
  EXPECT_TRUE(leaves_out(scene, "KHR_lights_punctual", "node 'triangle'"));
  EXPECT_TRUE(leaves_out(scene, "KHR_materials_variants", "the document"));
  EXPECT_TRUE(leaves_out(scene, "vertex colours COLOR_1", "mesh 'flat'"));
  EXPECT_TRUE(leaves_out(scene, "morph targets", "mesh 'flat'"));
  EXPECT_TRUE(leaves_out(scene, "primitives of mode LINES", "mesh 'flat'"));
  EXPECT_EQ(scene.unsupported.size(), 7U);
  EXPECT_EQ(scene.meshes.at(0).primitives.size(), 1U);
}

TEST(SceneMaterials, texture_coordinates_alone_are_harmless) {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] = builder.add("VEC2", 5126, std::vector<float>(6), 3);
  builder.primitive()["attributes"]["TANGENT"] = builder.add("VEC4", 5126, std::vector<float>(12), 3);
  EXPECT_TRUE(builder.load().unsupported.empty());
}

}  // namespace
