// SPDX-License-Identifier: Apache-2.0
// KHR_materials_pbrSpecularGlossiness becomes a dielectric whose reflectance is the specular
// colour.
#include "support/gltf_builder.h"
#include "support/picture_builder.h"

namespace {

using eikon::Material;
using eikon::Scene;
using scene_test::base64;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::message_of;
using scene_test::warns;

constexpr const char* kName = "KHR_materials_pbrSpecularGlossiness";

/// A material with `glossy` beside a metallic-roughness one that must not count.
Builder with_glossy(const Json& glossy) {
  Builder builder;
  builder.material() =
      Json::parse(R"({"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4],
    "metallicFactor": 1, "roughnessFactor": 0.9, "baseColorTexture": {"index": 0},
    "metallicRoughnessTexture": {"index": 0}}})");
  builder.material()["extensions"][kName] = glossy;
  for (const char* name : {"TEXCOORD_0", "TEXCOORD_1"})
    builder.primitive()["attributes"][name] = builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  for (const std::uint8_t value : {std::uint8_t{10}, std::uint8_t{100}}) {
    const picture_test::Samples rgba{value, 20, 30, 0, 40, 50, 60, 255, 70, 80, 90, 51};
    const std::string file = picture_test::png(3, 1, rgba, {.colour_type = PNG_COLOR_TYPE_RGB_ALPHA});
    builder.json["images"].push_back({{"uri", "data:;base64," + base64(file)}});
    builder.json["textures"].push_back({{"source", builder.json["images"].size() - 1}});
  }
  return builder;
}

TEST(SpecularGlossiness, factors_count_instead_of_the_metallic_roughness_ones_and_it_is_said_once) {
  Builder builder = with_glossy(
      {{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}}, {"specularFactor", {0.9, 0.6, 0.3}}, {"glossinessFactor", 0.75}});
  builder.material()["alphaMode"] = "BLEND";
  builder.json["materials"].push_back(builder.material());
  builder.json["extensionsRequired"] = {kName};
  const Scene scene = builder.load();
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.base_color, glm::vec3(0.5F, 0.25F, 0.125F));
  EXPECT_EQ(material.opacity, 0.75F);
  EXPECT_EQ(material.specular_color, glm::vec3(0.9F, 0.6F, 0.3F));
  EXPECT_EQ(material.ior, 0.0F);
  EXPECT_EQ(material.specular, 1.0F);
  EXPECT_EQ(material.metallic, 0.0F);
  EXPECT_EQ(material.roughness, 0.25F);
  EXPECT_FALSE(material.base_color_texture || material.metallic_roughness_texture || material.specular_color_texture);
  EXPECT_TRUE(scene.unsupported.empty());
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(
      contains(scene.warnings[0], "material 'paint' and 1 more: KHR_materials_pbrSpecularGlossiness is archived"));
}

TEST(SpecularGlossiness, defaults_are_a_smooth_white_mirror) {
  const Scene scene = with_glossy(Json::object()).load();
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.base_color, glm::vec3(1));
  EXPECT_EQ(material.opacity, 1.0F);
  EXPECT_EQ(material.specular_color, glm::vec3(1));
  EXPECT_EQ(material.roughness, 0.0F);
}

TEST(SpecularGlossiness, textures_keep_their_colours_and_glossiness_becomes_roughness) {
  Builder builder = with_glossy({{"diffuseTexture", {{"index", 0}}},
                                 {"specularGlossinessTexture", {{"index", 1}, {"texCoord", 1}}},
                                 {"glossinessFactor", 0.5}});
  const Scene scene = builder.load();
  const Material& material = scene.materials.at(0);
  ASSERT_TRUE(material.base_color_texture && material.specular_color_texture && material.metallic_roughness_texture);
  EXPECT_TRUE(material.base_color_texture->srgb);
  EXPECT_TRUE(material.specular_color_texture->srgb);
  EXPECT_FALSE(material.metallic_roughness_texture->srgb);
  EXPECT_EQ(material.metallic_roughness_texture->uv_set, 1U);
  EXPECT_EQ(scene.images.at(material.base_color_texture->image).rgba8.at(0), 0x001E140AU);
  EXPECT_EQ(scene.images.at(material.specular_color_texture->image).rgba8.at(0), 0x001E1464U);
  // 255 - glossinessFactor x alpha, in G; the factor of roughness is 1.
  EXPECT_EQ(material.roughness, 1.0F);
  const auto& rough = scene.images.at(material.metallic_roughness_texture->image);
  EXPECT_EQ(rough.width, 3U);
  EXPECT_EQ(rough.height, 1U);
  ASSERT_EQ(rough.rgba8.size(), 3U);
  EXPECT_EQ(rough.rgba8[0] >> 8U & 0xFFU, 255U);
  EXPECT_EQ(rough.rgba8[1] >> 8U & 0xFFU, 128U);
  EXPECT_EQ(rough.rgba8[2] >> 8U & 0xFFU, 230U);
}

TEST(SpecularGlossiness, textures_that_cannot_be_seen_are_not_read) {
  Builder rough = with_glossy({{"specularGlossinessTexture", {{"index", 1}}}, {"glossinessFactor", 0}});
  Scene scene = rough.load();
  EXPECT_EQ(scene.images.size(), 1U);
  EXPECT_EQ(scene.materials.at(0).roughness, 1.0F);
  rough = with_glossy(
      {{"specularGlossinessTexture", {{"index", 1}}}, {"glossinessFactor", 0}, {"specularFactor", {0, 0, 0}}});
  EXPECT_TRUE(rough.load().images.empty());
  // One image made of another serves all materials of the same glossiness.
  Builder two = with_glossy({{"specularGlossinessTexture", {{"index", 1}}}});
  two.json["materials"].push_back(two.material());
  Json second = two.primitive();
  second["material"] = 1;
  two.json["meshes"][0]["primitives"].push_back(second);
  scene = two.load();
  EXPECT_EQ(scene.images.size(), 2U);
  EXPECT_EQ(scene.materials[0].metallic_roughness_texture->image, scene.materials[1].metallic_roughness_texture->image);
}

TEST(SpecularGlossiness, M24_values_out_of_range_are_clamped_and_of_the_wrong_type_refused) {
  const Scene scene =
      with_glossy({{"diffuseFactor", {2, -1, 0.5, 3}}, {"specularFactor", {5, 0, 0}}, {"glossinessFactor", 9}}).load();
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(1, 0, 0.5F));
  EXPECT_EQ(scene.materials.at(0).roughness, 0.0F);
  for (const char* what :
       {"diffuseFactor 2", "diffuseFactor -1", "diffuseFactor 3", "specularFactor 5", "glossinessFactor 9"})
    EXPECT_TRUE(warns(scene, std::string("material 'paint': ") + what)) << what;
  for (const Json& bad :
       {Json{{"diffuseFactor", {1, 1, 1}}}, Json{{"specularFactor", 1}}, Json{{"glossinessFactor", "1"}},
        Json{{"diffuseTexture", {{"index", 99}}}}, Json{{"specularGlossinessTexture", 3}}}) {
    const std::string message = message_of([&] { with_glossy(bad).load(); });
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, kName)) << message;
  }
}

}  // namespace
