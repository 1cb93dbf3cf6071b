// SPDX-License-Identifier: Apache-2.0
// Materials, and that whatever is left out is said once.
#include <tuple>

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
    EXPECT_TRUE(mentions(message, "material 'paint'") && mentions(message, "mediumPriority")) << message;
  }
}

TEST(SceneMaterials, clearcoat_and_sheen_arrive_with_their_textures) {
  Builder builder;
  builder.material() = Json::parse(R"({"name": "velvet", "extensions": {
    "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
    "KHR_materials_sheen": {"sheenColorFactor": [1, 0.5, 0.25], "sheenRoughnessFactor": 0.75}}})");
  builder.json["extensionsRequired"] = {"KHR_materials_clearcoat", "KHR_materials_sheen"};
  const Scene scene = builder.load();
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.clearcoat, 0.5F);
  EXPECT_EQ(material.clearcoat_roughness, 0.25F);
  EXPECT_EQ(material.sheen_color, glm::vec3(1, 0.5F, 0.25F));
  EXPECT_EQ(material.sheen_roughness, 0.75F);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneMaterials, M24_layers_out_of_range_are_clamped_and_of_the_wrong_type_refused) {
  Builder builder;
  Json& extensions = builder.material()["extensions"];
  extensions["KHR_materials_clearcoat"] = {{"clearcoatFactor", 2}, {"clearcoatRoughnessFactor", -1}};
  extensions["KHR_materials_sheen"] = {{"sheenColorFactor", {3, -1, 0.5}}, {"sheenRoughnessFactor", 7}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).clearcoat, 1.0F);
  EXPECT_EQ(scene.materials.at(0).clearcoat_roughness, 0.0F);
  EXPECT_EQ(scene.materials.at(0).sheen_color, glm::vec3(1, 0, 0.5F));
  EXPECT_EQ(scene.materials.at(0).sheen_roughness, 1.0F);
  for (const char* what : {"clearcoatFactor 2", "clearcoatRoughnessFactor -1", "sheenColorFactor 3",
                           "sheenColorFactor -1", "sheenRoughnessFactor 7"})
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + what)) << what;
  for (const auto& [extension, key, value] :
       {std::tuple("KHR_materials_clearcoat", "clearcoatFactor", R"("much")"),
        std::tuple("KHR_materials_clearcoat", "clearcoatTexture", R"({"index": 9})"),
        std::tuple("KHR_materials_clearcoat", "clearcoatNormalTexture", R"({})"),
        std::tuple("KHR_materials_sheen", "sheenColorFactor", "[1, 1]"),
        std::tuple("KHR_materials_sheen", "sheenRoughnessTexture", "3")}) {
    Builder broken;
    broken.material()["extensions"][extension][key] = Json::parse(value);
    const std::string message = message_of([&] { broken.load(); });
    EXPECT_TRUE(mentions(message, "material 'paint'") && mentions(message, extension)) << message;
  }
}

TEST(SceneMaterials, anisotropy_and_conductors_arrive) {
  Builder builder;
  builder.material() = Json::parse(R"({"name": "brass", "extensions": {
    "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 1.25},
    "EIKON_materials_conductor": {"eta": [0.5, 1, 1.5], "k": [3, 2, 0]}}})");
  builder.json["extensionsRequired"] = {"KHR_materials_anisotropy", "EIKON_materials_conductor"};
  const Scene scene = builder.load();
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.anisotropy, 0.5F);
  EXPECT_EQ(material.anisotropy_rotation_rad, 1.25);
  ASSERT_TRUE(material.conductor);
  EXPECT_EQ(material.conductor->eta, glm::vec3(0.5F, 1, 1.5F));
  EXPECT_EQ(material.conductor->k, glm::vec3(3, 2, 0));
  EXPECT_TRUE(scene.unsupported.empty());

  Builder gold;
  gold.material()["extensions"]["EIKON_materials_conductor"] = {{"metal", "Au"}};
  const Scene named = gold.load();
  ASSERT_TRUE(named.materials.at(0).conductor);
  EXPECT_EQ(named.materials.at(0).conductor->eta, glm::vec3(0.16779F, 0.350409F, 1.508458F));
}

TEST(SceneMaterials, M24_conductors_and_anisotropy_out_of_range_are_clamped_or_refused) {
  Builder builder;
  Json& extensions = builder.material()["extensions"];
  extensions["KHR_materials_anisotropy"] = {{"anisotropyStrength", 2}};
  extensions["EIKON_materials_conductor"] = {{"eta", {-1, 1, 1e30}}, {"k", {1, -2, 1}}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).anisotropy, 1.0F);
  EXPECT_EQ(scene.materials.at(0).conductor->eta, glm::vec3(0, 1, 16384));
  EXPECT_EQ(scene.materials.at(0).conductor->k, glm::vec3(1, 0, 1));
  for (const char* what : {"anisotropyStrength 2", "eta -1", "eta 1e+30", "k -2"})
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + what)) << what;
  for (const auto& [content, says] :
       {std::pair(R"({"metal": "Unobtainium"})", "use one of Ag, Al, Au"), std::pair(R"({"metal": 3})", "metal"),
        std::pair(R"({"eta": [1, 1, 1]})", "needs"), std::pair(R"({"eta": [1, 1], "k": [1, 1, 1]})", "eta"),
        std::pair(R"({"metal": "Au", "k": [1, 1, 1]})", "leave one out"), std::pair("{}", "needs"),
        std::pair("7", "is not an object")}) {
    Builder broken;
    broken.material()["extensions"]["EIKON_materials_conductor"] = Json::parse(content);
    const std::string message = message_of([&] { broken.load(); });
    EXPECT_TRUE(mentions(message, "material 'paint'") && mentions(message, says)) << message;
  }
}

TEST(SceneMaterials, highlights_arrive_clamped_or_refused) {
  Builder builder;
  builder.json["extensionsRequired"] = {"EIKON_materials_phong"};
  Json& extensions = builder.material()["extensions"];
  extensions["EIKON_materials_phong"] = Json::parse(R"({"shininess": 8, "specular": [0.5, 0.25, 0]})");
  const Scene scene = builder.load();
  ASSERT_TRUE(scene.materials.at(0).phong);
  EXPECT_EQ(scene.materials.at(0).phong->shininess, 8.0F);
  EXPECT_EQ(scene.materials.at(0).phong->specular, glm::vec3(0.5F, 0.25F, 0));
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());

  extensions["EIKON_materials_phong"] = Json::parse(R"({"shininess": 1e9, "specular": [2, -1, 0]})");
  const Scene clamped = builder.load();
  EXPECT_EQ(clamped.materials.at(0).phong->shininess, 1e4F);
  EXPECT_EQ(clamped.materials.at(0).phong->specular, glm::vec3(1, 0, 0));
  EXPECT_EQ(clamped.out_of_range.size(), 3U);
  EXPECT_TRUE(warns(clamped, "material 'paint': shininess 1e+09 clamped to 10000"));

  for (const auto& [content, says] :
       {std::pair(R"({"shininess": "much"})", "shininess"), std::pair(R"({"specular": 1})", "specular"),
        std::pair("[]", "is not an object")}) {
    extensions["EIKON_materials_phong"] = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(mentions(message, "material 'paint'") && mentions(message, says)) << message;
  }
  extensions["EIKON_materials_phong"] = Json::object();
  extensions["EIKON_materials_conductor"] = {{"metal", "Au"}};
  EXPECT_TRUE(mentions(message_of([&] { builder.load(); }), "leave one out"));
}

TEST(SceneMaterials, diffuse_transmission_arrives_clamped_or_refused) {
  Builder builder;
  builder.json["extensionsRequired"] = {"KHR_materials_diffuse_transmission"};
  Json& extension = builder.material()["extensions"]["KHR_materials_diffuse_transmission"];
  extension = Json::parse(R"({"diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [0.5, 1, 0]})");
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).diffuse_transmission, 0.25F);
  EXPECT_EQ(scene.materials.at(0).diffuse_transmission_color, glm::vec3(0.5F, 1, 0));
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());

  extension = Json::parse(R"({"diffuseTransmissionFactor": 2, "diffuseTransmissionColorFactor": [-1, 1, 3]})");
  const Scene clamped = builder.load();
  EXPECT_EQ(clamped.materials.at(0).diffuse_transmission, 1.0F);
  EXPECT_EQ(clamped.materials.at(0).diffuse_transmission_color, glm::vec3(0, 1, 1));
  for (const char* what :
       {"diffuseTransmissionFactor 2", "diffuseTransmissionColorFactor -1", "diffuseTransmissionColorFactor 3"})
    EXPECT_TRUE(warns(clamped, std::string("material 'paint': ") + what)) << what;

  for (const auto& [content, says] :
       {std::pair(R"({"diffuseTransmissionFactor": "half"})", "diffuseTransmissionFactor"),
        std::pair(R"({"diffuseTransmissionColorFactor": [1, 1]})", "diffuseTransmissionColorFactor"),
        std::pair(R"({"diffuseTransmissionTexture": {"index": 7}})", "diffuseTransmissionTexture"),
        std::pair("7", "is not an object")}) {
    extension = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(mentions(message, "material 'paint'") && mentions(message, says)) << message;
  }
}

TEST(SceneMaterials, dispersion_arrives_and_stays_below_what_glass_can_have) {
  const auto dispersion = [](const char* text) {
    Builder builder;
    builder.material()["extensions"]["KHR_materials_dispersion"]["dispersion"] = Json::parse(text);
    const Scene scene = builder.load();
    return std::pair(scene.materials.at(0).dispersion, scene.warnings.size());
  };
  EXPECT_EQ(dispersion("0.25"), std::pair(0.25F, std::size_t{0}));
  EXPECT_EQ(dispersion("-1"), std::pair(0.0F, std::size_t{1}));
  EXPECT_EQ(dispersion("100"), std::pair(39.0F, std::size_t{1}));
  EXPECT_TRUE(mentions(message_of([&] { dispersion("\"much\""); }), "KHR_materials_dispersion"));
}

TEST(SceneMaterials, an_anisotropic_mesh_without_directions_is_isotropic_and_says_so) {
  Builder builder;
  builder.material()["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 1}};
  const Scene flat = builder.load();
  EXPECT_TRUE(flat.meshes.at(0).primitives.at(0).tangents_object.empty());
  EXPECT_TRUE(warns(flat, "mesh 'flat', primitive 0: material 'paint' is anisotropic"));
  builder.primitive()["attributes"]["TEXCOORD_0"] = builder.add("VEC2", 5126, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  const Scene placed = builder.load();
  EXPECT_FALSE(placed.meshes.at(0).primitives.at(0).tangents_object.empty());
  EXPECT_TRUE(placed.warnings.empty());
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
  EXPECT_TRUE(mentions(message_of([&] { builder.load(); }), "material 'paint': emissiveStrength"));
}

TEST(SceneMaterials, what_is_left_out_is_named_unless_it_changes_nothing) {
  EXPECT_TRUE(Builder().load().unsupported.empty());
  Builder builder;
  builder.material()["name"] = "rich";
  builder.material()["extensions"] = {{"KHR_materials_volume_scatter", Json::object()},
                                      {"KHR_materials_pbrSpecularGlossiness", Json::object()},
                                      {"VENDOR_\nunheard_of", Json::object()}};
  const Scene scene = builder.load();
  for (const char* feature :
       {"KHR_materials_volume_scatter", "KHR_materials_pbrSpecularGlossiness", "VENDOR_ unheard_of"}) {
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

TEST(SceneMaterials, thin_films_are_read_in_their_units_and_held_to_their_range) {
  Builder builder;
  EXPECT_EQ(builder.load().materials.at(0).iridescence, 0);
  builder.material()["extensions"] = {{"KHR_materials_iridescence", {{"iridescenceFactor", 1}}}};
  const eikon::Material plain = builder.load().materials.at(0);
  EXPECT_EQ(plain.iridescence, 1);
  EXPECT_EQ(plain.film_index, 1.3F);
  EXPECT_EQ(plain.film_thickness_nm[0], 100);
  EXPECT_EQ(plain.film_thickness_nm[1], 400);
  builder.material()["extensions"] = {
      {"KHR_materials_iridescence",
       {{"iridescenceFactor", 2}, {"iridescenceIor", 0.5}, {"iridescenceThicknessMaximum", -3}}}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).iridescence, 1);
  EXPECT_EQ(scene.materials.at(0).film_index, 1);
  EXPECT_EQ(scene.materials.at(0).film_thickness_nm[1], 0);
  EXPECT_EQ(scene.out_of_range.size(), 3U);
  builder.material()["extensions"]["KHR_materials_iridescence"] = {{"iridescenceIor", "thick"}};
  EXPECT_TRUE(mentions(message_of([&] { builder.load(); }), "iridescenceIor"));
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

TEST(SceneMaterials, features_outside_materials_are_named_with_their_owner) {
  Builder builder;
  builder.json["skins"] = {{{"joints", {0}}}};
  builder.json["animations"] = {{{"name", "walk"},
                                 {"samplers", {{{"input", 0}, {"output", 0}}}},
                                 {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
  builder.json["extensions"] = {{"ACME_weather", {{"rain", 1}}}};
  builder.node()["skin"] = 0;
  builder.primitive()["attributes"]["COLOR_1"] = 0;
  builder.primitive()["targets"] = {{{"POSITION", 0}}};
  builder.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const Scene scene = builder.load();
  EXPECT_TRUE(leaves_out(scene, "skin", "node 'triangle'"));
  EXPECT_TRUE(leaves_out(scene, "animation", "animation 'walk'"));
  EXPECT_TRUE(leaves_out(scene, "ACME_weather", "the document"));
  EXPECT_TRUE(leaves_out(scene, "vertex colours COLOR_1", "mesh 'flat'"));
  EXPECT_TRUE(leaves_out(scene, "morph targets", "mesh 'flat'"));
  EXPECT_TRUE(leaves_out(scene, "primitives of mode LINES", "mesh 'flat'"));
  EXPECT_EQ(scene.unsupported.size(), 6U);
  EXPECT_EQ(scene.meshes.at(0).primitives.size(), 1U);
}

TEST(SceneMaterials, texture_coordinates_alone_are_harmless) {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] = builder.add("VEC2", 5126, std::vector<float>(6), 3);
  builder.primitive()["attributes"]["TANGENT"] = builder.add("VEC4", 5126, std::vector<float>(12), 3);
  EXPECT_TRUE(builder.load().unsupported.empty());
}

Builder with_variants() {
  Builder builder;
  builder.json["materials"] = Json::parse(R"([{"name": "plain"}, {"name": "red"}, {"name": "blue"}])");
  builder.json["extensions"]["KHR_materials_variants"] =
      Json::parse(R"({"variants": [{"name": "warm"}, {"name": "cold"}, {"name": "bare"}]})");
  builder.json["extensionsUsed"] = builder.json["extensionsRequired"] = {"KHR_materials_variants"};
  builder.primitive()["material"] = 0;
  builder.primitive()["extensions"]["KHR_materials_variants"] =
      Json::parse(R"({"mappings": [{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]})");
  return builder;
}

TEST(SceneMaterials, a_variant_chooses_the_materials_of_primitives) {
  const Builder builder = with_variants();
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", builder.text());
  const auto shown = [&](const std::string& variant) {
    const Scene scene = eikon::load_scene(path, variant);
    EXPECT_EQ(scene.variants, (std::vector<std::string>{"warm", "cold", "bare"}));
    EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());
    return std::pair(scene.materials.at(scene.meshes.at(0).primitives.at(0).material).name, scene.hash);
  };
  EXPECT_EQ(shown("").first, "plain");
  EXPECT_EQ(shown("warm").first, "red");
  EXPECT_EQ(shown("cold").first, "blue");
  EXPECT_EQ(shown("bare").first, "plain") << "no mapping";
  EXPECT_EQ(shown("warm"), shown("warm"));
  EXPECT_NE(shown("warm").second, shown("cold").second) << "images of two variants are not to be merged";
  EXPECT_NE(shown("").second, shown("warm").second);
  const std::string message = message_of([&] { eikon::load_scene(path, "hot"); });
  EXPECT_TRUE(mentions(message, "no variant 'hot'") && mentions(message, "'warm', 'cold', 'bare'")) << message;
  const auto plain = folder.write("plain.gltf", Builder().text());
  EXPECT_TRUE(mentions(message_of([&] { eikon::load_scene(plain, "hot"); }), "leave --variant out"));
}

TEST(SceneMaterials, variants_of_the_wrong_types_are_refused_with_their_place) {
  for (const auto& [content, says] :
       {std::pair("7", "KHR_materials_variants"), std::pair("{}", "'mappings' is missing"),
        std::pair(R"({"mappings": 3})", "mappings"), std::pair(R"({"mappings": [3]})", "mapping 0"),
        std::pair(R"({"mappings": [{"variants": [0]}]})", "material"),
        std::pair(R"({"mappings": [{"material": 9, "variants": [0]}]})", "material"),
        std::pair(R"({"mappings": [{"material": 1}]})", "'variants' is missing"),
        std::pair(R"({"mappings": [{"material": 1, "variants": [3]}]})", "3 variants"),
        std::pair(R"({"mappings": [{"material": 1, "variants": ["warm"]}]})", "3 variants"),
        std::pair(R"({"mappings": [{"material": 1, "variants": [-1]}]})", "3 variants")}) {
    Builder builder = with_variants();
    builder.primitive()["extensions"]["KHR_materials_variants"] = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(mentions(message, "mesh 'flat', primitive 0") && mentions(message, says)) << content << ": " << message;
  }
  for (const char* content : {"7", "{}", R"({"variants": 1})", R"({"variants": [1]})", R"({"variants": [{}]})",
                              R"({"variants": [{"name": 4}]})"}) {
    Builder builder = with_variants();
    builder.json["extensions"]["KHR_materials_variants"] = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(mentions(message, "KHR_materials_variants")) << content << ": " << message;
  }
}

}  // namespace
