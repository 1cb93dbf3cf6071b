// SPDX-License-Identifier: Apache-2.0
// KHR_materials_variants.
#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;

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
    const Scene scene = eikon::load_scene(path, {.variant = variant, .animation = {}});
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
  const std::string message = message_of([&] { eikon::load_scene(path, {.variant = "hot", .animation = {}}); });
  EXPECT_TRUE(contains(message, "no variant 'hot'") && contains(message, "'warm', 'cold', 'bare'")) << message;
  const auto plain = folder.write("plain.gltf", Builder().text());
  EXPECT_TRUE(contains(message_of([&] { eikon::load_scene(plain, {.variant = "hot", .animation = {}}); }),
                       "leave --variant out"));
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
    EXPECT_TRUE(contains(message, "mesh 'flat', primitive 0") && contains(message, says)) << content << ": " << message;
  }
  for (const char* content : {"7", "{}", R"({"variants": 1})", R"({"variants": [1]})", R"({"variants": [{}]})",
                              R"({"variants": [{"name": 4}]})"}) {
    Builder builder = with_variants();
    builder.json["extensions"]["KHR_materials_variants"] = Json::parse(content);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, "KHR_materials_variants")) << content;
  }
}

}  // namespace
