// SPDX-License-Identifier: Apache-2.0
// Textures with an image by an extension and one of their own, which takes its place where the
// first cannot be read.
#include <utility>

#include "support/gltf_builder.h"
#include "support/picture_builder.h"

namespace {

using eikon::Scene;
using picture_test::plain_png;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::message_of;

Json image_of(const std::string& file) { return {{"uri", "data:image/png;base64," + scene_test::base64(file)}}; }

/// A base colour texture with image 1, `file`, by an extension, and with image 0 of its own: `own`.
Builder with_fallback(const char* extension, const std::string& file,
                      const std::string& own = plain_png(1, 1, 7, 8, 9)) {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] =
      builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  builder.json["images"] = {image_of(own), image_of(file)};
  builder.json["textures"] = {{{"source", 0}, {"extensions", {{extension, {{"source", 1}}}}}}};
  builder.material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  return builder;
}

/// Pictures whose headers are right and whose data end early, and the extensions that name such.
std::vector<std::pair<const char*, std::string>> damaged_pictures() {
  const std::string webp = picture_test::webp(16, 16, picture_test::Samples(1024, 200), false);
  const std::string basis = picture_test::etc1s_quarters();
  std::string cut = basis;
  std::fill(cut.begin() + std::ptrdiff_t(cut.size() / 2), cut.end(), '\xFF');
  return {{"EXT_texture_webp", webp.substr(0, webp.size() - 8)}, {"KHR_texture_basisu", cut}};
}

TEST(SceneFallback, is_used_and_said_once) {
  const std::string basis = picture_test::ktx2(4, 2, {1}, {.format = 0, .scheme = 1});
  for (const auto& [extension, file] :
       {std::pair("EXT_texture_avif", std::string("avif")), std::pair("KHR_texture_basisu", basis),
        std::pair("EXT_texture_webp", std::string("RIFF....WEBPVP8 ..."))}) {
    Builder builder = with_fallback(extension, file);
    builder.material()["normalTexture"] = {{"index", 0}};
    const Scene scene = builder.load();
    ASSERT_TRUE(scene.materials[0].base_color_texture);
    EXPECT_EQ(scene.images.at(scene.materials[0].base_color_texture->image).rgba8.at(0), 0xFF090807U);
    EXPECT_TRUE(scene.unsupported.empty());
    ASSERT_EQ(scene.warnings.size(), 1U);
    EXPECT_TRUE(contains(scene.warnings[0], std::string("texture 0: ") + extension + " is not read") &&
                contains(scene.warnings[0], "its PNG or JPEG is used (and 1 more)"))
        << scene.warnings[0];
  }
}

TEST(SceneFallback, takes_the_place_of_pictures_whose_data_are_damaged) {
  for (const auto& [extension, file] : damaged_pictures()) {
    Builder builder = with_fallback(extension, file);
    builder.json["textures"].push_back({{"source", 0}});
    builder.material()["emissiveTexture"] = {{"index", 1}};
    for (const bool shares : {false, true}) {
      builder.material()["emissiveFactor"] = {shares ? 1 : 0, 0, 0};  // the other texture is read where it is 1
      const Scene scene = builder.load();
      const auto& image = scene.images.at(scene.materials[0].base_color_texture.value().image);
      EXPECT_EQ(image.rgba8, std::vector<std::uint32_t>{0xFF090807U}) << extension;
      EXPECT_EQ(image.width, 1U);
      EXPECT_EQ(image.height, 1U);
      EXPECT_EQ(scene.images.size(), shares ? 2U : 1U);
      ASSERT_EQ(scene.warnings.size(), 1U);
      EXPECT_TRUE(
          contains(scene.warnings[0], std::string("texture 0: ") + extension + " is not read: image 1: is a ") &&
          scene.warnings[0].ends_with("its PNG or JPEG is used"))
          << scene.warnings[0];
    }
  }
}

TEST(SceneFallback, is_what_roughness_is_made_of) {
  const auto [extension, file] = damaged_pictures()[0];
  Builder builder = with_fallback(
      extension, file, picture_test::png(2, 1, {0, 0, 0, 255, 0, 0, 0, 0}, {.colour_type = PNG_COLOR_TYPE_RGBA}));
  builder.material()["extensions"] = {
      {"KHR_materials_pbrSpecularGlossiness", {{"specularGlossinessTexture", {{"index", 0}}}}}};
  const Scene scene = builder.load();
  const auto& rough = scene.images.at(scene.materials[0].metallic_roughness_texture.value().image);
  EXPECT_EQ(rough.width, 2U);
  EXPECT_EQ(rough.height, 1U);
  EXPECT_EQ(rough.rgba8, (std::vector<std::uint32_t>{0xFF000000U, 0xFF00FF00U}));
}

TEST(SceneFallback, that_is_damaged_too_or_missing_is_refused) {
  for (const auto& [extension, file] : damaged_pictures()) {
    const std::string png = plain_png(9, 9);
    Builder builder = with_fallback(extension, file, png.substr(0, png.size() / 2));
    std::string message = message_of([&] { (void)builder.load(); });
    EXPECT_TRUE(contains(message, "image 1: is a ") && contains(message, "image 0: is a ")) << message;
    builder.json["textures"][0].erase("source");
    message = message_of([&] { (void)builder.load(); });
    EXPECT_TRUE(contains(message, "image 1: is a ") && !contains(message, "image 0")) << message;
  }
}

}  // namespace
