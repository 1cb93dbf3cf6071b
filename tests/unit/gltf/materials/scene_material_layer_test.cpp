// SPDX-License-Identifier: Apache-2.0
// What extensions lay on, or put in the place of, the usual reflection: each arrives, is held to
// its range or refused.
#include <tuple>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::message_of;
using scene_test::warns;

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
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, extension)) << message;
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
  ASSERT_EQ(material.lobe, eikon::Lobe::conductor);
  EXPECT_EQ(material.conductor_eta, glm::vec3(0.5F, 1, 1.5F));
  EXPECT_EQ(material.conductor_k, glm::vec3(3, 2, 0));
  EXPECT_TRUE(scene.unsupported.empty());

  Builder gold;
  gold.material()["extensions"]["EIKON_materials_conductor"] = {{"metal", "Au"}};
  const Scene named = gold.load();
  ASSERT_EQ(named.materials.at(0).lobe, eikon::Lobe::conductor);
  EXPECT_EQ(named.materials.at(0).conductor_eta, glm::vec3(0.16779F, 0.350409F, 1.508458F));
}

TEST(SceneMaterials, M24_conductors_and_anisotropy_out_of_range_are_clamped_or_refused) {
  Builder builder;
  Json& extensions = builder.material()["extensions"];
  extensions["KHR_materials_anisotropy"] = {{"anisotropyStrength", 2}};
  extensions["EIKON_materials_conductor"] = {{"eta", {-1, 1, 1e30}}, {"k", {1, -2, 1}}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).anisotropy, 1.0F);
  EXPECT_EQ(scene.materials.at(0).conductor_eta, glm::vec3(0, 1, 16384));
  EXPECT_EQ(scene.materials.at(0).conductor_k, glm::vec3(1, 0, 1));
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
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, says)) << message;
  }
}

TEST(SceneMaterials, highlights_arrive_clamped_or_refused) {
  Builder builder;
  builder.json["extensionsRequired"] = {"EIKON_materials_phong"};
  Json& extensions = builder.material()["extensions"];
  extensions["EIKON_materials_phong"] = Json::parse(R"({"shininess": 8, "specular": [0.5, 0.25, 0]})");
  const Scene scene = builder.load();
  ASSERT_EQ(scene.materials.at(0).lobe, eikon::Lobe::phong);
  EXPECT_EQ(scene.materials.at(0).phong_shininess, 8.0F);
  EXPECT_EQ(scene.materials.at(0).phong_specular, glm::vec3(0.5F, 0.25F, 0));
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());

  extensions["EIKON_materials_phong"] = Json::parse(R"({"shininess": 1e9, "specular": [2, -1, 0]})");
  const Scene clamped = builder.load();
  EXPECT_EQ(clamped.materials.at(0).phong_shininess, 1e4F);
  EXPECT_EQ(clamped.materials.at(0).phong_specular, glm::vec3(1, 0, 0));
  EXPECT_EQ(clamped.out_of_range.size(), 3U);
  EXPECT_TRUE(warns(clamped, "material 'paint': shininess 1e+09 clamped to 10000"));

  for (const auto& [content, says] :
       {std::pair(R"({"shininess": "much"})", "shininess"), std::pair(R"({"specular": 1})", "specular"),
        std::pair("[]", "is not an object")}) {
    extensions["EIKON_materials_phong"] = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, says)) << message;
  }
  extensions["EIKON_materials_phong"] = Json::object();
  extensions["EIKON_materials_conductor"] = {{"metal", "Au"}};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "leave one out"));
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
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, says)) << message;
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
  EXPECT_TRUE(contains(message_of([&] { dispersion("\"much\""); }), "KHR_materials_dispersion"));
}

TEST(SceneMaterials, an_anisotropic_mesh_without_directions_is_isotropic_and_says_so) {
  Builder builder;
  builder.material()["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 1}};
  const Scene flat = builder.load();
  EXPECT_TRUE(flat.meshes.at(0).primitives.at(0).tangents_object.empty());
  EXPECT_TRUE(warns(flat, "mesh 'flat', primitive 0: material 'paint' is anisotropic"));
  builder.primitive()["attributes"]["TEXCOORD_0"] =
      builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  const Scene placed = builder.load();
  EXPECT_FALSE(placed.meshes.at(0).primitives.at(0).tangents_object.empty());
  EXPECT_TRUE(placed.warnings.empty());
}

TEST(SceneMaterials, thin_films_are_read_in_their_units_and_held_to_their_range) {
  Builder builder;
  EXPECT_EQ(builder.load().materials.at(0).iridescence, 0);
  builder.material()["extensions"] = {{"KHR_materials_iridescence", {{"iridescenceFactor", 1}}}};
  const eikon::Material plain = builder.load().materials.at(0);
  EXPECT_EQ(plain.iridescence, 1);
  EXPECT_EQ(plain.thin_film_index, 1.3F);
  EXPECT_EQ(plain.thin_film_thickness_nm[0], 100);
  EXPECT_EQ(plain.thin_film_thickness_nm[1], 400);
  builder.material()["extensions"] = {
      {"KHR_materials_iridescence",
       {{"iridescenceFactor", 2}, {"iridescenceIor", 0.5}, {"iridescenceThicknessMaximum", -3}}}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.materials.at(0).iridescence, 1);
  EXPECT_EQ(scene.materials.at(0).thin_film_index, 1);
  EXPECT_EQ(scene.materials.at(0).thin_film_thickness_nm[1], 0);
  EXPECT_EQ(scene.out_of_range.size(), 3U);
  builder.material()["extensions"]["KHR_materials_iridescence"] = {{"iridescenceIor", "thick"}};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "iridescenceIor"));
}

}  // namespace
