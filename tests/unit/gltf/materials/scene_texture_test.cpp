// SPDX-License-Identifier: Apache-2.0
// Textures of materials: which images are read, how they are addressed, and what is refused.
#include <cmath>
#include <numbers>
#include <span>

#include "support/picture_builder.h"
#include "gltf/document/buffer_views.h"
#include "gltf/materials/textures.h"
#include "support/gltf_builder.h"
#include "support/paths.h"

namespace {

using eikon::Material;
using eikon::Scene;
using eikon::Texture;
using eikon::TextureFilter;
using eikon::Wrap;
using picture_test::plain_png;
using scene_test::base64;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::leaves_out;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::warns;

std::string data_uri(const std::string& file) { return "data:image/png;base64," + base64(file); }

/// Texture coordinates for the triangle, so that nothing is missing.
void add_coordinates(Builder& builder) {
  for (const char* name : {"TEXCOORD_0", "TEXCOORD_1"})
    builder.primitive()["attributes"][name] = builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
}

/// A document whose material has one base colour texture with `image`, {"uri": ...} or
/// {"bufferView": ...}.
Builder with_image(const Json& image) {
  Builder builder;
  add_coordinates(builder);
  builder.json["images"] = {image};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  return builder;
}

Builder with_png(const std::string& file = plain_png(2, 1)) { return with_image({{"uri", data_uri(file)}}); }

Json& slot(Builder& builder) { return builder.material()["pbrMetallicRoughness"]["baseColorTexture"]; }

Texture only_texture(const Builder& builder) {
  const Scene scene = builder.load();
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.materials.at(0).base_color_texture);
  return scene.materials.at(0).base_color_texture.value_or(Texture{});
}

TEST(SceneTextures, every_slot_arrives_colours_as_srgb_and_the_rest_as_it_is) {
  Builder builder;
  add_coordinates(builder);
  for (int i = 0; i < 7; ++i) {
    builder.json["images"].push_back({{"uri", data_uri(plain_png(1, 1, i, 0, 0))}});
    builder.json["textures"].push_back({{"source", i}});
  }
  builder.json["materials"][0] = Json::parse(R"({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 3},
    "normalTexture": {"index": 2, "scale": -0.5}, "occlusionTexture": {"index": 1},
    "pbrMetallicRoughness": {"metallicFactor": 0.5, "baseColorTexture": {"index": 0},
                             "metallicRoughnessTexture": {"index": 1}},
    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 4}},
      "KHR_materials_volume": {"thicknessFactor": 1, "thicknessTexture": {"index": 0}},
      "KHR_materials_specular": {"specularTexture": {"index": 5}, "specularColorTexture": {"index": 6}}}})");
  const Scene scene = builder.load();
  const Material& material = scene.materials.at(0);
  ASSERT_EQ(scene.images.size(), 7U);
  const struct {
    const std::optional<Texture>& texture;
    std::uint32_t red;
    bool srgb;
  } rows[] = {{material.base_color_texture, 0, true},    {material.metallic_roughness_texture, 1, false},
              {material.normal_texture, 2, false},       {material.emissive_texture, 3, true},
              {material.transmission_texture, 4, false}, {material.specular_texture, 5, false},
              {material.specular_color_texture, 6, true}};
  for (const auto& row : rows) {
    ASSERT_TRUE(row.texture) << row.red;
    EXPECT_EQ(row.texture->srgb, row.srgb) << row.red;
    EXPECT_EQ(scene.images.at(row.texture->image).rgba8.at(0), 0xFF000000U | row.red);
  }
  EXPECT_EQ(material.normal_scale, -0.5F);
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());
}

TEST(SceneTextures, specular_ones_are_read_where_a_texture_makes_part_of_a_metal_dielectric) {
  Builder builder = with_png();
  builder.material()["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", 0}}}};  // a metal
  builder.material()["extensions"]["KHR_materials_specular"] = {{"specularTexture", {{"index", 0}}}};
  EXPECT_FALSE(builder.load().materials.at(0).specular_texture) << "a metal has none";
  builder.material()["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 0;
  EXPECT_TRUE(builder.load().materials.at(0).specular_texture);
}

TEST(SceneTextures, images_come_from_files_bufferviews_and_the_document_itself) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "maps");
  folder.write("maps/wood grain.png", plain_png(3, 2, 1, 2, 3));
  Builder builder = with_image({{"uri", "maps/wood%20grain.png"}});
  Scene scene = eikon::load_scene(folder.write("scene.gltf", builder.text()));
  ASSERT_EQ(scene.images.size(), 1U);
  EXPECT_EQ(scene.images[0].width, 3U);
  EXPECT_EQ(scene.images[0].height, 2U);
  EXPECT_EQ(scene.images[0].rgba8, std::vector<std::uint32_t>(6, 0xFF030201U));
  EXPECT_TRUE(contains(scene.images[0].name, "wood"));
  const std::string hash = scene.hash;
  folder.write("maps/wood grain.png", plain_png(3, 2, 1, 2, 4));
  EXPECT_NE(eikon::load_scene(folder / "scene.gltf").hash, hash);

  Builder inside;
  const std::string file = plain_png(1, 1, 7, 8, 9);
  const std::size_t view = inside.add_view(std::vector<char>(file.begin(), file.end()));
  inside.json["images"] = {{{"bufferView", view}, {"mimeType", "image/jpeg"}}};  // the first bytes count
  inside.json["textures"] = {{{"source", 0}}};
  slot(inside) = {{"index", 0}};
  scene = eikon::load_scene(folder.write("scene.glb", inside.glb_bytes()));
  EXPECT_EQ(scene.images.at(0).rgba8, std::vector<std::uint32_t>{0xFF090807U});

  EXPECT_EQ(with_png(plain_png(1, 1, 4, 5, 6)).load().images.at(0).rgba8, std::vector<std::uint32_t>{0xFF060504U});
}

TEST(SceneTextures, an_image_is_read_once_and_only_when_something_needs_it) {
  const TemporaryFolder folder;
  folder.write("a.png", plain_png(2, 2));
  Builder builder;
  add_coordinates(builder);
  builder.json["images"] = {
      {{"uri", "a.png"}}, {{"uri", "./a.png"}}, {{"uri", "../missing.png"}}, {{"uri", "bad.png"}}};
  for (int i = 0; i < 4; ++i) builder.json["textures"].push_back({{"source", i}});
  Json& material = builder.material();
  slot(builder) = {{"index", 0}};
  material["normalTexture"] = {{"index", 1}};
  // Times 0, shadows baked in, or of a material that nothing shows.
  material["emissiveTexture"] = {{"index", 2}};
  material["occlusionTexture"] = {{"index", 2}};
  material["extensions"]["KHR_materials_specular"]["specularTexture"] = {{"index", 3}};
  material["extensions"]["KHR_materials_transmission"] = {{"transmissionTexture", {{"index", 3}}}};
  builder.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 2}}}}}});
  const Scene scene = eikon::load_scene(folder.write("scene.gltf", builder.text()));
  EXPECT_EQ(scene.images.size(), 1U);
  EXPECT_EQ(scene.materials[0].base_color_texture->image, scene.materials[0].normal_texture->image);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneTextures, an_unlit_material_has_its_base_colour_alone) {
  Builder builder = with_png();
  builder.material()["extensions"] = {{"KHR_materials_unlit", Json::object()}};
  builder.material()["normalTexture"] = {{"index", 0}};
  builder.material()["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
  const Scene scene = builder.load();
  EXPECT_TRUE(scene.materials[0].base_color_texture);
  EXPECT_FALSE(scene.materials[0].normal_texture);
  EXPECT_FALSE(scene.materials[0].metallic_roughness_texture);
}

TEST(SceneTextures, M25_wrapping_and_filters_are_as_the_sampler_says) {
  Builder builder = with_png();
  const Texture plain = only_texture(builder);
  EXPECT_EQ(plain.wrap_u, Wrap::repeat);
  EXPECT_EQ(plain.wrap_v, Wrap::repeat);
  EXPECT_EQ(plain.filter, TextureFilter::linear);
  EXPECT_EQ(plain.uv_set, 0U);
  builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9987}}};
  builder.json["textures"][0]["sampler"] = 0;
  slot(builder)["texCoord"] = 1;
  const Texture texture = only_texture(builder);
  EXPECT_EQ(texture.wrap_u, Wrap::clamp);
  EXPECT_EQ(texture.wrap_v, Wrap::mirror);
  EXPECT_EQ(texture.filter, TextureFilter::nearest);
  EXPECT_EQ(texture.uv_set, 1U);
  builder.json["samplers"] = {{{"wrapS", 10497}, {"magFilter", 9729}}};
  EXPECT_EQ(only_texture(builder).filter, TextureFilter::linear);
  for (const char* key : {"wrapS", "wrapT", "magFilter"}) {
    builder.json["samplers"] = {{{key, 1234}}};
    EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "sampler 0"));
  }
}

glm::vec2 apply(const Texture& texture, const glm::vec2& uv) {
  return {glm::dot(texture.image_from_uv[0], glm::vec3(uv, 1)), glm::dot(texture.image_from_uv[1], glm::vec3(uv, 1))};
}

TEST(SceneTextures, M25_transforms_scale_turn_and_shift_in_this_order) {
  Builder builder = with_png();
  Json& transform = slot(builder)["extensions"]["KHR_texture_transform"];
  // The extension's own example: the lower left quadrant of the image (v is down), turned clockwise
  // by 90 degrees.
  transform = {{"offset", {0, 1}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}};
  Texture texture = only_texture(builder);
  const auto near = [&](const glm::vec2& uv, const glm::vec2& expected) {
    EXPECT_LT(glm::distance(apply(texture, uv), expected), 1e-6F) << uv.x << ' ' << uv.y;
  };
  near({0, 0}, {0, 1});
  near({1, 0}, {0, 0.5F});
  near({0, 1}, {0.5F, 1});
  near({1, 1}, {0.5F, 0.5F});
  // Scales before the rotation, so that it shears nothing.
  transform = {{"rotation", std::numbers::pi / 2}, {"scale", {4, 2}}};
  texture = only_texture(builder);
  near({1, 0}, {0, -4});
  near({0, 1}, {2, 0});
  // The other set of coordinates, and nothing else.
  transform = {{"texCoord", 1}};
  texture = only_texture(builder);
  EXPECT_EQ(texture.uv_set, 1U);
  near({0.25F, 0.75F}, {0.25F, 0.75F});
  transform = {{"scale", {0, 0}}, {"offset", {0.5, 0.25}}};
  texture = only_texture(builder);
  near({100, -7}, {0.5F, 0.25F});
  transform = {{"offset", {1e39, 0}}};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "KHR_texture_transform: goes beyond single precision"));
  for (const Json& bad :
       {Json{{"offset", 1}}, Json{{"scale", {1}}}, Json{{"rotation", "1"}}, Json{{"texCoord", -1}}, Json(3)}) {
    transform = bad;
    EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "baseColorTexture")) << bad;
  }
}

TEST(SceneTextures, formats_that_are_not_read_are_named_with_what_converts_them) {
  const auto scene_with = [](const char* extension) {
    Builder builder = with_png();
    builder.json["textures"] = {{{"extensions", {{extension, {{"source", 0}}}}}}};
    return builder.load();
  };
  EXPECT_TRUE(leaves_out(scene_with("MSFT_texture_dds"), "DDS images", "texture 0"));
  EXPECT_TRUE(leaves_out(scene_with("EXT_texture_avif"), "`avifdec`", "texture 0"));
  const Scene scene = scene_with("EXT_texture_avif");
  EXPECT_FALSE(scene.materials[0].base_color_texture);
  EXPECT_TRUE(scene.images.empty());
  // Told by the first bytes, whatever the file says.
  EXPECT_TRUE(leaves_out(with_png("DDS ...........").load(), "DDS images", "image 0"));
  EXPECT_TRUE(leaves_out(with_png("GIF89a.........").load(), "GIF images", "image 0"));
  Builder builder = with_png();
  builder.json["extensionsRequired"] = {"EXT_texture_avif"};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "`avifdec`"));
}

TEST(SceneTextures, webp_is_read_with_and_without_its_extension) {
  const std::string file = picture_test::webp(1, 1, {9, 8, 7, 128}, true);
  EXPECT_EQ(with_png(file).load().images.at(0).rgba8, std::vector<std::uint32_t>{0x80070809U});
  Builder builder = with_png(file);
  builder.json["images"].push_back({{"uri", data_uri(plain_png(1, 1, 1, 2, 3))}});
  builder.json["extensionsRequired"] = {"EXT_texture_webp"};
  builder.json["textures"] = {{{"source", 1}, {"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}}};
  const Texture texture = only_texture(builder);  // the extension's image counts, and nothing is left to be said
  EXPECT_EQ(builder.load().images.at(texture.image).rgba8, std::vector<std::uint32_t>{0x80070809U});
  for (const Json& bad : {Json(7), Json("0"), Json(-1)}) {
    builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = bad;
    EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "texture 0, EXT_texture_webp")) << bad;
  }
}

TEST(SceneTextures, basis_universal_is_read) {
  for (const std::string& file : {picture_test::etc1s_quarters(), picture_test::uastc_quarters()}) {
    Builder builder = with_png(file);
    builder.json["extensionsRequired"] = {"KHR_texture_basisu"};
    builder.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
    const Scene scene = builder.load();
    EXPECT_TRUE(scene.unsupported.empty());
    EXPECT_TRUE(scene.warnings.empty());
    const auto& image = scene.images.at(only_texture(builder).image);
    EXPECT_EQ(image.width, 8U);
    EXPECT_EQ(image.rgba8.at(63) >> 24U, 128U);
  }
}

TEST(SceneTextures, what_has_no_image_or_no_coordinates_is_left_out_and_said) {
  Builder builder = with_png();
  builder.json["textures"] = {Json::object()};
  Scene scene = builder.load();
  EXPECT_FALSE(scene.materials[0].base_color_texture);
  EXPECT_TRUE(warns(scene, "texture 0: left out, it has no image"));
  builder = with_png();
  slot(builder)["texCoord"] = 2;
  scene = builder.load();
  EXPECT_FALSE(scene.materials[0].base_color_texture);
  EXPECT_TRUE(leaves_out(scene, "TEXCOORD_2", "material 'paint', pbrMetallicRoughness, baseColorTexture"));
}

TEST(SceneTextures, sixteen_bits_reduced_to_eight_are_said) {
  const std::string deep = picture_test::png(1, 1, {0, 128, 255, 255, 0, 0}, {.depth = 16});
  EXPECT_TRUE(warns(with_png(deep).load(), "image 0: 16 bits per channel reduced to 8"));
}

TEST(SceneTextures, bad_images_are_one_line_with_image_file_and_reason) {
  const TemporaryFolder folder;
  const std::string good = plain_png(9, 9);
  folder.write("cut.png", good.substr(0, good.size() / 2));
  folder.write("text.png", "hello");
  folder.write("empty.png", "");
  folder.write("huge.png", picture_test::with_png_size(good, 16384, 16384));
  std::filesystem::create_directories(folder / "folder.png");
  std::filesystem::create_symlink("/etc/hostname", folder / "link.png");
  const auto message = [&](const Json& image) {
    return message_of([&] { eikon::load_scene(folder.write("scene.gltf", with_image(image).text())); });
  };
  for (const char* name : {"cut.png", "text.png", "empty.png", "huge.png", "folder.png", "link.png", "missing.png"}) {
    const std::string text = message({{"uri", name}});
    EXPECT_TRUE(contains(text, "image 0") && contains(text, name)) << text;
  }
  EXPECT_TRUE(contains(message({{"uri", "cut.png"}}), "truncated"));
  EXPECT_TRUE(contains(message({{"uri", "huge.png"}}), "cannot hold"));
  EXPECT_TRUE(contains(message({{"uri", "../cut.png"}}), "leads upwards"));
  EXPECT_TRUE(contains(message({{"uri", "file:///etc/passwd"}}), "scheme"));
  EXPECT_TRUE(contains(message({{"uri", "data:image/png;base64,!!!!"}}), "base64"));
  EXPECT_TRUE(contains(message(Json::object()), "exactly one"));
  EXPECT_TRUE(contains(message({{"bufferView", 99}}), "bufferView"));
  EXPECT_TRUE(contains(message({{"bufferView", 0}}), "neither PNG, JPEG, WebP nor KTX2"));  // positions
}

TEST(SceneTextures, all_images_together_stay_within_one_budget) {
  Json document = {{"images", Json::array()}, {"textures", Json::array()}, {"materials", {Json::object()}}};
  for (int i = 0; i < 3; ++i) {
    document["images"].push_back({{"uri", data_uri(plain_png(64, 64, i))}});
    document["textures"].push_back({{"source", i}});
  }
  document["materials"][0] = {{"a", {{"index", 0}}}, {"b", {{"index", 1}}}, {"c", {{"index", 2}}}};
  const eikon::Buffers buffers(document, {}, ".");
  eikon::WrongParts wrong;
  eikon::Notes unused;
  const eikon::BufferViews views(document, buffers, wrong, unused);
  const eikon::JsonView material{.value = document["materials"][0], .kind = "material", .index = 0};
  const auto load = [&](std::uint64_t budget_bytes) {
    Scene scene;
    eikon::Digest digest;
    eikon::Notes notes;
    eikon::TextureReader reader({.document = document, .views = views, .folder = ".", .budget_bytes = budget_bytes},
                                scene, digest, notes);
    for (const char* key : {"a", "b", "c"}) EXPECT_TRUE(reader.find(material, key, false));
    reader.decode();
    return scene.images.size();
  };
  EXPECT_EQ(load(std::uint64_t{3} * 64 * 64 * 4), 3U);
  const std::string text = message_of([&] { load(std::uint64_t{3} * 64 * 64 * 4 - 1); });
  EXPECT_TRUE(contains(text, "image 2") && contains(text, "4096 pixels") && contains(text, "scale them down")) << text;
}

TEST(SceneTextures, memory_of_a_decoder_counts_while_it_works_whatever_comes_after) {
  const std::string lossless = picture_test::webp(16, 16, picture_test::Samples(1024, 200), true);
  Json document = {{"images", {{{"uri", data_uri(lossless)}}, {{"uri", data_uri(plain_png(16, 16))}}}},
                   {"textures", {{{"source", 0}}, {{"source", 1}}}},
                   {"materials", {{{"a", {{"index", 0}}}, {"b", {{"index", 1}}}}}}};
  const eikon::Buffers buffers(document, {}, ".");
  eikon::WrongParts wrong;
  eikon::Notes unused;
  const eikon::BufferViews views(document, buffers, wrong, unused);
  const eikon::JsonView material{.value = document["materials"][0], .kind = "material", .index = 0};
  const auto find = [&](std::initializer_list<const char*> keys, std::uint64_t budget_bytes) {
    Scene scene;
    eikon::Digest digest;
    eikon::Notes notes;
    eikon::TextureReader reader({.document = document, .views = views, .folder = ".", .budget_bytes = budget_bytes},
                                scene, digest, notes);
    for (const char* key : keys) EXPECT_TRUE(reader.find(material, key, false));
  };
  find({"a"}, 2048);
  EXPECT_TRUE(contains(message_of([&] { find({"a"}, 2047); }), "scale them down"));
  find({"b", "a"}, 3072);
  EXPECT_TRUE(contains(message_of([&] { find({"b", "a"}, 3071); }), "scale them down"));
  find({"a", "b"}, 3072);
  EXPECT_TRUE(contains(message_of([&] { find({"a", "b"}, 3071); }), "scale them down"));
}

TEST(SceneTextures, poses_of_a_file_share_its_pixels_while_one_of_them_lives) {
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", with_png(plain_png(2, 2, 4, 5, 6)).text());
  auto first = std::make_unique<Scene>(eikon::load_scene(path));
  const std::shared_ptr<eikon::SceneMemory> memory = first->memory;
  const Scene second = eikon::load_scene(path, {}, eikon::MissingTangents::make, memory);
  EXPECT_EQ(first->images.at(0).rgba8.data(), second.images.at(0).rgba8.data());
  EXPECT_NE(eikon::load_scene(path).images.at(0).rgba8.data(), second.images.at(0).rgba8.data());
  first.reset();
  EXPECT_EQ(second.images.at(0).rgba8.at(0), 0xFF060504U);
}

}  // namespace
