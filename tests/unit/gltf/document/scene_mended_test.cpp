// SPDX-License-Identifier: Apache-2.0
// Files that people have: what they mean is beyond doubt, so they are read. What breaks a rule is
// said once, and is an error under --strict.
#include <fmt/format.h>

#include <functional>

#include "support/gltf_builder.h"

namespace {

using eikon::load_scene;
using eikon::Scene;
using scene_test::base64;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::message_of;
using scene_test::TemporaryFolder;

void expect_triangle(const Scene& scene) {
  ASSERT_EQ(scene.nodes.size(), 1U);
  const eikon::Primitive& primitive = scene.meshes.at(0).primitives.at(0);
  EXPECT_EQ(primitive.positions_object, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2}));
}

void expect_clean_triangle(const Scene& scene) {
  expect_triangle(scene);
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

void expect_mended_triangle(const Scene& scene, const std::string& says) {
  expect_triangle(scene);
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_EQ(scene.warnings, scene.out_of_range);
  EXPECT_TRUE(contains(scene.warnings[0], says));
}

Json buffer_with(const Builder& builder, const std::string& uri) {
  return {{{"byteLength", builder.buffer.size()}, {"uri", uri}}};
}

TEST(SceneMended, integers_may_be_written_with_a_fraction_of_zero_or_an_exponent) {
  const TemporaryFolder folder;
  std::string text = Builder().text();
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("\"componentType\":5126", "\"componentType\":5.126e3");
  replace("\"count\":3", "\"count\":3.0");
  replace("\"mesh\":0", "\"mesh\":0.0");
  replace("\"POSITION\":0", "\"POSITION\":0e0");
  replace("\"scene\":0", "\"scene\":0.0");
  replace("\"nodes\":[0]", "\"nodes\":[0.0]");
  expect_clean_triangle(load_scene(folder.write("a.gltf", text)));
  replace("\"count\":3.0", "\"count\":3.5");
  EXPECT_TRUE(contains(message_of([&] { load_scene(folder.write("a.gltf", text)); }), "'count' is not an integer"));
}

TEST(SceneMended, buffers_without_bytes_are_no_harm_where_nothing_reads_them) {
  Builder builder;
  builder.json["buffers"] = {buffer_with(builder, "data:;base64," + base64(builder.buffer))[0], {{"byteLength", 999}}};
  expect_clean_triangle(builder.load());
  builder.json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 36}});
  expect_mended_triangle(builder.load(), "bufferView 2: buffer 1 has neither a URI");
  builder.primitive()["attributes"]["NORMAL"] = 2;
  builder.json["accessors"].push_back({{"bufferView", 2}, {"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "bufferView 2: buffer 1 has neither a URI"));
}

TEST(SceneMended, data_uris_may_be_in_capitals_and_without_base64) {
  Builder builder;
  builder.json["buffers"] = buffer_with(builder, "DATA:application/octet-stream;BASE64," + base64(builder.buffer));
  expect_clean_triangle(builder.load());
  std::string escaped = "data:,";
  for (const char c : builder.buffer) escaped += fmt::format("%{:02x}", static_cast<unsigned char>(c));
  builder.json["buffers"] = buffer_with(builder, escaped);
  expect_clean_triangle(builder.load());
}

TEST(SceneMended, base64_may_have_its_signs_escaped) {
  Builder builder;
  std::string escaped;
  for (const char c : base64(builder.buffer + "\xfb\xff\xfe")) {
    const bool is_sign = c == '+' || c == '/' || c == '=';
    escaped += is_sign ? fmt::format("%{:02X}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  EXPECT_TRUE(contains(escaped, "%"));
  builder.json["buffers"] = buffer_with(builder, "data:application/octet-stream;base64," + escaped);
  expect_clean_triangle(builder.load());
}

TEST(SceneMended, paths_may_go_up_and_come_back) {
  const TemporaryFolder folder;
  Builder builder;
  std::filesystem::create_directory(folder.path() / "sub");
  folder.write("sub/data.bin", builder.buffer);
  folder.write("near.bin", builder.buffer);
  const std::string name = folder.path().filename().string();
  for (const std::string& uri : {std::string("sub/../near.bin"), std::string("sub/%2e%2e/sub/data.bin"),
                                 "../" + name + "/near.bin", std::string("none/../near.bin")}) {
    builder.json["buffers"] = buffer_with(builder, uri);
    SCOPED_TRACE(uri);
    expect_clean_triangle(load_scene(folder.write("scene.gltf", builder.text())));
  }
}

TEST(SceneMended, strides_that_are_no_multiple_of_4_are_read_as_they_are) {
  Builder builder;
  std::string bytes;
  for (const float c : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F}) {
    bytes += scene_test::bytes_of(std::vector<float>{c});
    if (bytes.size() % 14 == 12) bytes += "##";
  }
  builder.json["bufferViews"][0] = {
      {"buffer", 0}, {"byteOffset", builder.buffer.size()}, {"byteLength", bytes.size()}, {"byteStride", 14}};
  builder.buffer += bytes;
  expect_mended_triangle(builder.load(), "bufferView 0: 'byteStride' 14 is not a multiple of 4");
  builder.json["bufferViews"][0]["byteStride"] = 11;
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "overlap"));
}

TEST(SceneMended, the_last_column_of_a_matrix_needs_no_padding) {
  Builder builder;
  builder.add("MAT3", kUnsignedByte, std::vector<std::uint8_t>(23), 2);  // 12 bytes, then 11
  expect_clean_triangle(builder.load());
  builder.json["bufferViews"].back()["byteLength"] = 22;
  expect_mended_triangle(builder.load(), "accessor 2: 2 elements need bytes 0 to 23");
}

TEST(SceneMended, wrong_parts_that_the_scene_does_not_use_are_left_out_and_refused_where_it_does) {
  struct Part {
    std::function<void(Builder&)> add, use;
    const char* says;
  };
  const Json bad_primitive = {{"attributes", {{"POSITION", 99}}}};
  const std::vector<Part> parts{
      {[](Builder& b) {
         b.json["accessors"].push_back({{"componentType", 1}, {"count", 3}, {"type", "VEC3"}});
       },
       [](Builder& b) { b.primitive()["attributes"]["_CUSTOM"] = 2; }, "'componentType' 1 is none"},
      {[](Builder& b) {
         b.json["accessors"].push_back({{"name", 7}, {"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
       },
       [](Builder& b) { b.primitive()["attributes"]["NORMAL"] = 2; }, "'name' is not a string"},
      {[](Builder& b) { b.json["accessors"].push_back(7); }, [](Builder& b) { b.primitive()["indices"] = 2; },
       "accessor 2: is not an object"},
      {[](Builder& b) {
         b.json["materials"].push_back({{"name", "bad"}, {"doubleSided", 1}});
       },
       [](Builder& b) { b.primitive()["material"] = 1; }, "material 'bad': 'doubleSided'"},
      {[](Builder& b) {
         b.json["materials"].push_back(
             {{"name", "bad"},
              {"emissiveFactor", {1, 1, 1}},
              {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e300}}}}}});
       },
       [](Builder& b) { b.primitive()["material"] = 1; }, "material 'bad': emissiveStrength"},
      {[](Builder& b) {
         b.json["materials"].push_back({{"name", "bad"}, {"extras", {{"lightGroup", "a.b"}}}});
       },
       [](Builder& b) { b.primitive()["material"] = 1; }, "material 'bad', extras: 'lightGroup'"},
      {[=](Builder& b) {
         b.json["meshes"].push_back({{"primitives", {bad_primitive}}});
       },
       [](Builder& b) { b.node()["mesh"] = 1; }, "mesh 1, primitive 0"},
      {[](Builder& b) {
         b.json["nodes"].push_back({{"name", "bad"}, {"mesh", 7}});
       },
       [](Builder& b) { b.node()["children"] = {1}; }, "node 'bad': 'mesh' names mesh 7"},
      {[](Builder& b) {
         b.json["cameras"] = {{{"type", "fisheye"}}};
       },
       [](Builder& b) { b.node()["camera"] = 0; }, "camera 0: 'type'"},
      {[](Builder& b) {
         b.json["skins"] = {{{"joints", {4}}}};
       },
       [](Builder& b) { b.node()["skin"] = 0; }, "skin 0"},
      {[](Builder& b) {
         b.json["textures"] = {{{"source", 5}}};
       },
       [](Builder& b) {
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "texture 0"},
      {[](Builder& b) {
         b.json["samplers"] = {{{"wrapS", 7}}};
       },
       [](Builder& b) {
         b.json["textures"] = {{{"sampler", 0}}};
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "sampler 0: 'wrapS' 7"},
      {[](Builder& b) {
         b.json["images"] = {{{"uri", 7}}};
       },
       [](Builder& b) {
         b.json["textures"] = {{{"source", 0}}};
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "image 0: 'uri'"}};
  for (const Part& part : parts) {
    SCOPED_TRACE(part.says);
    Builder builder;
    part.add(builder);
    expect_mended_triangle(builder.load(), part.says);
    EXPECT_TRUE(contains(builder.load().warnings[0], "left out, as the scene does not use it: "));
    part.use(builder);
    EXPECT_TRUE(contains(message_of([&] { builder.load(); }), part.says));
  }
}

TEST(SceneMended, light_groups_keep_their_order_whatever_is_wrong_with_a_material) {
  Builder builder;
  builder.json["materials"].push_back({{"emissiveFactor", {1, 1, 1}}, {"extras", {{"lightGroup", "key"}}}});
  builder.json["materials"].push_back({{"name", "paper"}, {"extras", {{"lightGroup", "fill"}}}});
  const std::vector<std::string> groups{"rest", "key", "fill"};
  EXPECT_EQ(builder.load().light_groups, groups);
  builder.json["materials"][1]["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", 1e300}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.light_groups, groups);
  EXPECT_EQ(scene.materials.at(2).name, "paper");
  EXPECT_EQ(scene.materials.at(2).light_group, 2U);
}

TEST(SceneMended, wrong_animations_are_left_out_since_a_scene_can_stand_still) {
  for (const Json& animation : {Json({{"samplers", {{{"input", 9}, {"output", 0}}}}}), Json(7),
                                Json({{"samplers", {{{"input", 0}, {"output", 0}}}},
                                      {"channels", {{{"sampler", 0}, {"target", {{"node", 5}}}}}}})}) {
    Builder builder;
    builder.json["animations"] = {animation};
    const Scene scene = builder.load();
    EXPECT_EQ(scene.out_of_range.size(), 1U);
    EXPECT_TRUE(contains(scene.out_of_range.at(0), "animation 0"));
  }
}

TEST(SceneMended, wrong_parts_of_a_kind_are_counted_and_too_many_are_refused) {
  Builder builder;
  for (int i = 0; i < 3; ++i) builder.json["nodes"].push_back(i);
  expect_mended_triangle(builder.load(), "does not use it (and 2 more of its kind): node 1: is not an object");
  for (int i = 0; i < 2000; ++i) builder.json["nodes"].push_back(i);
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "is not an object"));
}

TEST(SceneMended, a_primitive_without_positions_is_left_out) {
  Builder builder;
  builder.json["meshes"][0]["primitives"].push_back({{"attributes", Json::object()}});
  const Scene scene = builder.load();
  expect_triangle(scene);
  EXPECT_EQ(scene.meshes[0].primitives.size(), 1U);
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "primitive 1: left out, it has no POSITION"));
}

TEST(SceneMended, a_pointer_of_git_lfs_is_named_wherever_it_stands) {
  const TemporaryFolder folder;
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:" + std::string(64, 'a') + "\nsize 12345\n";
  const auto expect_pointer = [](const std::filesystem::path& scene, const std::string& who) {
    const std::string message = message_of([&] { load_scene(scene); });
    EXPECT_TRUE(contains(message, who));
    EXPECT_TRUE(contains(message, "is a pointer of Git LFS"));
    EXPECT_TRUE(contains(message, "`git lfs pull`"));
  };
  expect_pointer(folder.write("scene.glb", pointer), "scene.glb");
  expect_pointer(folder.write("scene.gltf", pointer), "scene.gltf");
  folder.write("data.bin", pointer);
  folder.write("image.png", pointer);
  Builder builder;
  builder.json["buffers"] = buffer_with(builder, "data.bin");
  expect_pointer(folder.write("buffer.gltf", builder.text()), "'data.bin'");
  builder.json.erase("buffers");
  builder.json["images"] = {{{"uri", "image.png"}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  expect_pointer(folder.write("image.gltf", builder.text()), "'image.png'");
}

}  // namespace
