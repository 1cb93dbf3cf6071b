// SPDX-License-Identifier: Apache-2.0
// Materials of glTF itself, glass, and values out of their range.
#include <tuple>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
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
  EXPECT_EQ(scene.materials[1].roughness, 1.0F);
  EXPECT_TRUE(scene.unsupported.empty());
}

TEST(SceneMaterials, an_empty_material_has_the_defaults_of_gltf) {
  Builder builder;
  builder.material() = Json::object();
  const Scene scene = builder.load();
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.base_color, glm::vec3(1));
  EXPECT_EQ(material.opacity, 1.0F);
  EXPECT_EQ(material.metallic, 1.0F);
  EXPECT_EQ(material.roughness, 1.0F);
  EXPECT_EQ(material.ior, 1.5F);
  EXPECT_EQ(material.specular, 1.0F);
  EXPECT_EQ(material.specular_color, glm::vec3(1));
  EXPECT_EQ(material.transmission, 0.0F);
  EXPECT_FALSE(material.solid);
  EXPECT_EQ(material.attenuation_color, glm::vec3(1));
  EXPECT_EQ(material.attenuation_distance, 0.0F);
  EXPECT_EQ(material.emission, glm::vec3(0));
  EXPECT_EQ(material.alpha_mode, eikon::AlphaMode::opaque);
  EXPECT_EQ(material.alpha_cutoff, 0.5F);
  EXPECT_FALSE(material.double_sided);
  EXPECT_FALSE(material.unlit);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneMaterials, glass_arrives_with_its_index_its_volume_and_its_alpha) {
  Builder builder;
  builder.material() = Json::parse(R"({"name": "glass", "alphaMode": "MASK", "alphaCutoff": 0.25,
    "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": 0, "roughnessFactor": 0},
    "extensions": {"KHR_materials_ior": {"ior": 1.33}, "KHR_materials_transmission": {"transmissionFactor": 0.75},
      "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 0.5, 0]},
      "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 0]}}})");
  builder.json["extensionsRequired"] = {
      "KHR_materials_ior",   "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_specular",
      "KHR_materials_unlit", "KHR_texture_transform",      "KHR_lights_punctual",  "KHR_materials_emissive_strength"};
  const Scene scene = builder.load();
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.ior, 1.33F);
  EXPECT_EQ(material.transmission, 0.75F);
  EXPECT_EQ(material.specular, 0.5F);
  EXPECT_EQ(material.specular_color, glm::vec3(2, 0.5F, 0));
  EXPECT_TRUE(material.solid);
  EXPECT_EQ(material.attenuation_distance, 2.0F);
  EXPECT_EQ(material.attenuation_color, glm::vec3(0.5F, 1, 0));
  EXPECT_EQ(material.opacity, 0.5F);
  EXPECT_EQ(material.alpha_mode, eikon::AlphaMode::mask);
  EXPECT_EQ(material.alpha_cutoff, 0.25F);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.warnings.empty());

  builder.material()["extensions"]["KHR_materials_volume"].erase("thicknessFactor");
  builder.material()["alphaMode"] = "BLEND";
  EXPECT_FALSE(builder.load().materials.at(0).solid);
  EXPECT_EQ(builder.load().materials.at(0).alpha_mode, eikon::AlphaMode::blend);
}

TEST(SceneMaterials, the_priority_of_a_medium_arrives) {
  Builder builder;
  EXPECT_FALSE(builder.load().materials.at(0).medium_priority.has_value());
  builder.material()["extras"] = 5;  // extras may be anything
  EXPECT_FALSE(builder.load().materials.at(0).medium_priority.has_value());
  for (const int priority : {0, -7, 1000000}) {
    builder.material()["extras"] = {{"mediumPriority", priority}, {"other", "thing"}};
    const Scene scene = builder.load();
    EXPECT_EQ(scene.materials.at(0).medium_priority, priority);
    EXPECT_TRUE(scene.warnings.empty());
  }
}

TEST(SceneMaterials,
     M24_priorities_that_are_no_integer_or_out_of_range_are_brought_there_and_of_the_wrong_type_refused) {
  Builder builder;
  for (const auto& [value, taken, warning] :
       {std::tuple(1.25, 1, "mediumPriority 1.25 is no integer within +-1e+06; taken as 1"),
        std::tuple(2e6, 1000000, "mediumPriority 2e+06"), std::tuple(-1e300, -1000000, "mediumPriority -1e+300")}) {
    builder.material()["extras"] = {{"mediumPriority", value}};
    const Scene scene = builder.load();
    EXPECT_EQ(scene.materials.at(0).medium_priority, taken);
    ASSERT_EQ(scene.out_of_range.size(), 1U);  // an error under --strict
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + warning)) << scene.out_of_range.back();
  }
  for (const char* value : {R"("high")", "[1]", "true", "null", "{}"}) {
    builder.material()["extras"] = {{"mediumPriority", Json::parse(value)}};
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, "mediumPriority")) << message;
  }
}

TEST(SceneMaterials, M13_odd_indices_of_refraction_are_legal_or_clamped) {
  const auto ior = [](const char* text) {
    Builder builder;
    builder.material()["extensions"]["KHR_materials_ior"]["ior"] = Json::parse(text);
    const Scene scene = builder.load();
    return std::pair(scene.materials.at(0).ior, scene.warnings.size());
  };
  EXPECT_EQ(ior("0"), std::pair(0.0F, std::size_t{0}));
  EXPECT_EQ(ior("1"), std::pair(1.0F, std::size_t{0}));
  EXPECT_EQ(ior("1.000001"), std::pair(1.000001F, std::size_t{0}));
  EXPECT_EQ(ior("1e9"), std::pair(1e9F, std::size_t{0}));
  EXPECT_EQ(ior("0.5"), std::pair(1.0F, std::size_t{1}));
  EXPECT_EQ(ior("-1"), std::pair(1.0F, std::size_t{1}));
  EXPECT_EQ(ior("1e40"), std::pair(1e9F, std::size_t{1}));
}

TEST(SceneMaterials, M15_distances_without_end_and_next_to_nothing_stay_apart) {
  const auto distance = [](const char* text) {
    Builder builder;
    builder.material()["extensions"]["KHR_materials_volume"]["attenuationDistance"] = Json::parse(text);
    const Scene scene = builder.load();
    return std::pair(scene.materials.at(0).attenuation_distance, scene.warnings.size());
  };
  EXPECT_EQ(distance("1e300"), std::pair(0.0F, std::size_t{0}));  // 0 stands for infinite
  EXPECT_GT(distance("1e-300").first, 0.0F);
  EXPECT_EQ(distance("0"), std::pair(0.0F, std::size_t{1}));
  EXPECT_EQ(distance("-1"), std::pair(0.0F, std::size_t{1}));
}

TEST(SceneMaterials, an_unlit_material_is_its_base_colour_and_no_light) {
  Builder builder;
  builder.material()["emissiveFactor"] = {1, 1, 1};
  builder.material()["extensions"] = {{"KHR_materials_unlit", Json::object()},
                                      {"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
  const Scene scene = builder.load();
  EXPECT_TRUE(scene.materials.at(0).unlit);
  EXPECT_EQ(scene.materials.at(0).emission, glm::vec3(0));
  EXPECT_EQ(scene.materials.at(0).transmission, 0.0F);
  EXPECT_EQ(eikon::first_emitter(scene), nullptr);
}

TEST(SceneMaterials, M24_values_out_of_range_are_clamped_with_a_warning_naming_the_material) {
  Builder builder;
  builder.material()["pbrMetallicRoughness"] = {
      {"baseColorFactor", {1.5, -0.5, 0.5, 3}}, {"metallicFactor", 2}, {"roughnessFactor", 7}};
  builder.material()["emissiveFactor"] = {2, 0, 0};
  Json& extensions = builder.material()["extensions"];
  extensions["KHR_materials_emissive_strength"]["emissiveStrength"] = -3;
  extensions["KHR_materials_transmission"]["transmissionFactor"] = 1.25;
  extensions["KHR_materials_specular"] = {{"specularFactor", -2}, {"specularColorFactor", {-1, 7, 1}}};
  extensions["KHR_materials_volume"] = {{"thicknessFactor", -1}, {"attenuationColor", {4, 1, 1}}};
  builder.material()["alphaCutoff"] = -1;
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(1, 0, 0.5F));
  EXPECT_EQ(scene.materials.at(0).opacity, 1.0F);
  EXPECT_EQ(scene.materials.at(0).metallic, 1.0F);
  EXPECT_EQ(scene.materials.at(0).roughness, 1.0F);
  EXPECT_EQ(scene.materials.at(0).emission, glm::vec3(0));
  EXPECT_EQ(scene.materials.at(0).transmission, 1.0F);
  EXPECT_EQ(scene.materials.at(0).specular, 0.0F);
  EXPECT_EQ(scene.materials.at(0).specular_color, glm::vec3(0, 7, 1));
  EXPECT_FALSE(scene.materials.at(0).solid);
  EXPECT_EQ(scene.materials.at(0).attenuation_color, glm::vec3(1));
  EXPECT_EQ(scene.materials.at(0).alpha_cutoff, 0.0F);
  for (const char* what :
       {"baseColorFactor 1.5", "baseColorFactor -0.5", "metallicFactor", "roughnessFactor", "emissiveFactor 2",
        "emissiveStrength -3", "transmissionFactor", "specularFactor -2", "specularColorFactor -1", "thicknessFactor",
        "attenuationColor 4", "alphaCutoff", "baseColorFactor 3"}) {
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + what)) << what;
  }
}

TEST(SceneMaterials, emission_beyond_single_precision_is_refused_by_name) {
  Builder builder;
  builder.material()["emissiveFactor"] = {1, 1, 1};
  builder.material()["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1e39;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "material 'paint': emissiveStrength"));
}

}  // namespace
