// SPDX-License-Identifier: Apache-2.0
// Tangents of files that have none, where KHR_texture_transform turns or mirrors the normal map.
#include <numbers>

#include "support/gltf_builder.h"
#include "support/picture_builder.h"

namespace {

using eikon::Scene;
using picture_test::plain_png;
using scene_test::base64;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kFloat;

TEST(SceneTextures, tangents_that_a_file_lacks_follow_the_transformed_image) {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] =
      builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  builder.json["images"] = {{{"uri", "data:image/png;base64," + base64(plain_png(2, 1))}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.primitive()["attributes"]["NORMAL"] =
      builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  const auto tangent = [&](std::size_t material, const Json& transform) {
    builder.json["materials"][material]["normalTexture"] = {{"index", 0}};
    if (!transform.is_null())
      builder.json["materials"][material]["normalTexture"]["extensions"]["KHR_texture_transform"] = transform;
    const Scene scene = builder.load();
    return scene.meshes.at(0).primitives.at(material).tangents_object[0];
  };
  const glm::vec4 plain = tangent(0, nullptr);
  // Another primitive of the same accessors.
  builder.json["materials"].push_back(builder.json["materials"][0]);
  builder.json["meshes"][0]["primitives"].push_back(builder.primitive());
  builder.json["meshes"][0]["primitives"][1]["material"] = 1;
  EXPECT_EQ(tangent(1, nullptr), plain);
  EXPECT_EQ(tangent(1, {{"offset", {0.5, 0.25}}, {"scale", {2, 2}}}), plain);
  EXPECT_EQ(tangent(1, {{"scale", {0, 0}}}), plain) << "the image is a single colour there";
  EXPECT_EQ(tangent(1, {{"scale", {1, -1}}, {"offset", {0, 1}}}), glm::vec4(glm::vec3(plain), -plain.w))
      << "upside down";
  const glm::vec4 turned = tangent(1, {{"rotation", std::numbers::pi / 2}});
  EXPECT_LT(std::abs(glm::dot(glm::vec3(turned), glm::vec3(plain))), 1e-6F);
  EXPECT_EQ(turned.w, plain.w);
  EXPECT_EQ(tangent(0, nullptr), plain);
}

}  // namespace
