// SPDX-License-Identifier: Apache-2.0
// Files that are no scene, or only part of one, and URIs that lead astray: each is refused in one
// line, none crashes.
#include <fcntl.h>
#include <sys/stat.h>

#include <random>

#include "support/gltf_builder.h"

namespace {

using eikon::load_scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::glb;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::u32_bytes;

TEST(SceneBadFile, text_that_is_not_json_is_refused) {
  const TemporaryFolder folder;
  const std::string good = Builder().text();
  std::string replaced = good;
  replaced.replace(replaced.find("\"2.0\""), 5, "\"2.\xFF\"");
  const std::vector<std::pair<std::string, std::string>> rows{
      {"", "empty"},
      {"   \n ", "not glTF"},
      {"hello\nworld", "not glTF"},
      {"[1, 2]", "not glTF"},
      {"{\"asset\": {\"version\": \"2.0\"}", "not valid JSON"},
      {"{\"asset\": {\"version\": \"2.0\"}} trailing", "not valid JSON"},
      {"{\"asset\": {\"version\": \"2.0\"}, \"scene\": NaN}", "not valid JSON"},
      {"{\"asset\": {\"version\": \"2.0\"}, \"scene\": 1e999}", "not valid JSON"},
      {std::string("{\"a\": \"x\0y\"}", 12), "not valid JSON"},
      {replaced, "not valid JSON"},
      {"\x89PNG\r\n\x1a\n", "not glTF"},
  };
  for (const auto& [text, says] : rows) {
    const std::string message = message_of([&, &bytes = text] { load_scene(folder.write("a.gltf", bytes)); });
    EXPECT_TRUE(contains(message, says));
  }
}

TEST(SceneBadFile, G20_json_nested_a_hundred_thousand_deep_is_an_error_not_a_stack_overflow) {
  const TemporaryFolder folder;
  const std::size_t depth = 100000;
  const std::string head = R"({"asset": {"version": "2.0"}, "extras": )";
  std::string objects;
  for (std::size_t i = 0; i < depth; ++i) objects += "{\"a\":";
  for (const std::string& text :
       {head + std::string(depth, '[') + std::string(depth, ']') + "}",
        head + objects + "1" + std::string(depth, '}') + "}", "{" + std::string(depth, '[')}) {
    const std::string message = message_of([&] { load_scene(folder.write("deep.gltf", text)); });
    EXPECT_TRUE(contains(message, "nested deeper"));
  }
  // Brackets in strings are no nesting, escaped quotes do not end them.
  const std::string in_string = head + "\"\\\"" + std::string(depth, '[') + "\"}";
  EXPECT_TRUE(load_scene(folder.write("string.gltf", in_string)).nodes.empty());
}

TEST(SceneBadFile, truncated_files_are_refused_wherever_they_end) {
  const TemporaryFolder folder;
  const std::string binary = Builder().glb_bytes(), text = Builder().text();
  for (std::size_t length = 0; length < binary.size(); length += length < 32 ? 1 : 5) {
    EXPECT_THROW(load_scene(folder.write("a.glb", binary.substr(0, length))), eikon::InputError) << length;
  }
  for (std::size_t length = 0; length < text.size(); length += 7) {
    EXPECT_THROW(load_scene(folder.write("a.gltf", text.substr(0, length))), eikon::InputError) << length;
  }
}

TEST(SceneBadFile, broken_glb_containers_are_refused) {
  const TemporaryFolder folder;
  const std::string json = Builder().json.dump();
  const auto with_header = [](std::size_t version, std::size_t length, const std::string& rest) {
    return "glTF" + u32_bytes(version) + u32_bytes(length) + rest;
  };
  const std::string empty_json = u32_bytes(0) + "JSON";
  std::string wrong_first = glb(json, "");
  wrong_first.replace(16, 4, "BIN\0", 4);
  const std::vector<std::pair<std::string, std::string>> rows{
      {"{\"asset\": {\"version\": \"2.0\"}}", "does not begin with 'glTF'"},
      {"glTG" + glb(json, "").substr(4), "does not begin with 'glTF'"},
      {with_header(1, 20, empty_json), "version 1"},
      {with_header(2, 1000, empty_json), "truncated"},
      {with_header(2, 0xFFFFFFFF, empty_json), "truncated"},
      {with_header(2, 0, empty_json), "0 bytes in all"},
      {with_header(2, 12, empty_json), "12 bytes in all"},
      {with_header(2, 20, empty_json), "JSON chunk is missing"},
      {with_header(2, 20, u32_bytes(0xFFFFFFFF) + "JSON"), "chunk 0"},
      {with_header(2, 20, u32_bytes(0xFFFFFFF8) + "JSON"), "chunk 0"},
      {wrong_first, "first chunk is not JSON"},
      {glb(json, "", false), "buffer"},
      {glb(R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4}]})", ""), "buffer 0"},
  };
  for (const auto& [bytes, says] : rows) {
    const std::string message = message_of([&, &content = bytes] { load_scene(folder.write("a.glb", content)); });
    EXPECT_TRUE(contains(message, says));
  }
}

TEST(SceneBadFile, what_is_no_readable_regular_file_is_refused_at_once) {
  const TemporaryFolder folder;
  EXPECT_TRUE(contains(message_of([&] { load_scene(folder.path() / "none.gltf"); }), "no such file"));
  EXPECT_TRUE(contains(message_of([&] { load_scene(folder.path()); }), "is a directory"));
  EXPECT_TRUE(contains(message_of([&] { load_scene(""); }), "no such file"));
  EXPECT_TRUE(contains(message_of([] { load_scene("/dev/null"); }), "not a regular file"));
  EXPECT_TRUE(contains(message_of([&] { load_scene(folder.path() / "a\nb.gltf"); }), "a\\x0ab"));
  const auto fifo = folder.path() / "pipe.gltf";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_TRUE(contains(message_of([&] { load_scene(fifo); }), "not a regular file"));
  const auto sparse = folder.write("huge.glb", "glTF");
  std::filesystem::resize_file(sparse, std::uintmax_t{1} << 40U);
  EXPECT_TRUE(contains(message_of([&] { load_scene(sparse); }), "more than"));
  const auto loop = folder.path() / "loop.gltf";
  std::filesystem::create_symlink(loop, loop);
  EXPECT_TRUE(contains(message_of([&] { load_scene(loop); }), "cannot be opened"));
  const auto closed = folder.write("closed.gltf", Builder().text());
  std::filesystem::permissions(closed, std::filesystem::perms::none);
  if (std::ifstream(closed)) return;  // root reads everything
  EXPECT_TRUE(contains(message_of([&] { load_scene(closed); }), "cannot be opened"));
}

TEST(SceneBadFile, uris_lead_only_to_regular_files_in_the_folder_of_the_scene) {
  const TemporaryFolder outside, folder;
  Builder builder;
  outside.write("secret.bin", builder.buffer);
  folder.write("short.bin", "abc");
  folder.write("empty.bin", "");
  std::filesystem::create_directory(folder.path() / "sub");
  std::filesystem::create_symlink(outside.path() / "secret.bin", folder.path() / "link.bin");
  std::filesystem::create_symlink(outside.path(), folder.path() / "linked");
  ASSERT_EQ(::mkfifo((folder.path() / "pipe.bin").c_str(), 0600), 0);
  const std::vector<std::pair<std::string, std::string>> rows{
      {(outside.path() / "secret.bin").string(), "absolute"},
      {"../" + outside.path().filename().string() + "/secret.bin", "'..'"},
      {"%2e%2e/secret.bin", "'..'"},
      {"sub/../../secret.bin", "'..'"},
      {"%2Fetc%2Fpasswd", "absolute"},
      {"file:///etc/passwd", "scheme"},
      {"FILE%3a///etc/passwd", "scheme"},
      {"http://localhost/a.bin", "scheme"},
      {"c:secret.bin", "scheme"},
      {"sub\\..\\secret.bin", "backslash"},
      {"sub%5Csecret.bin", "backslash"},
      {"secret.bin%00.png", "control character"},
      {"secret%0a.bin", "control character"},
      {"secret%zz.bin", "%-escape"},
      {"secret.bin%2", "%-escape"},
      {"", "empty"},
      {"link.bin", "symbolic link"},
      {"linked/secret.bin", "symbolic link"},
      {"none.bin", "no such file"},
      {"$(touch%20hacked)", "no such file"},
      {"pipe.bin", "not a regular file"},
      {"sub", "is a directory"},
      {".", "is a directory"},
      {"empty.bin", "is empty"},
      {"short.bin", "only 3 bytes"},
  };
  for (const auto& [uri, says] : rows) {
    builder.json["buffers"] = {{{"byteLength", builder.buffer.size()}, {"uri", uri}}};
    const auto path = folder.write("scene.gltf", builder.text());
    const std::string message = message_of([&] { load_scene(path); });
    EXPECT_TRUE(contains(message, says)) << uri;
    EXPECT_TRUE(contains(message, "buffer 0"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "hacked"));
  // What stays inside is fine: a folder below, dots in a name, a link to a neighbour.
  folder.write("sub/..data.bin", builder.buffer);
  std::filesystem::create_symlink("sub/..data.bin", folder.path() / "near.bin");
  for (const char* uri : {"sub/..data.bin", "./sub/..data.bin", "near.bin"}) {
    builder.json["buffers"] = {{{"byteLength", builder.buffer.size()}, {"uri", uri}}};
    EXPECT_EQ(load_scene(folder.write("scene.gltf", builder.text())).nodes.size(), 1U) << uri;
  }
}

TEST(SceneBadFile, accessors_shared_by_countless_primitives_are_refused_before_memory_runs_out) {
  Builder builder;
  const std::vector<std::uint8_t> indices(3000000, 0);
  const std::size_t shared = builder.add("SCALAR", kUnsignedByte, indices, indices.size());
  Json primitive = builder.primitive();
  primitive["indices"] = shared;
  Json& primitives = builder.json["meshes"][0]["primitives"] = Json::array();
  for (int i = 0; i < 20000; ++i) primitives.push_back(primitive);  // 240 GB of indices from 5 MB
  const TemporaryFolder folder;
  const std::string message = message_of([&] { load_scene(folder.write("a.glb", builder.glb_bytes())); });
  EXPECT_TRUE(contains(message, "GB of memory"));
}

// Bytes changed at random: the scene loads or is refused, and what loads keeps its promises.
TEST(SceneBadFile, random_damage_never_gets_past_the_checks) {
  Builder builder;
  builder.primitive()["attributes"]["NORMAL"] =
      builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  builder.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"rotation", {0, 0, 0, 1}}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const std::string good = builder.glb_bytes();
  const TemporaryFolder folder;
  std::mt19937 random(20261121);
  int loaded = 0, refused = 0;
  for (int round = 0; round < 400; ++round) {
    std::string bytes = good;
    for (int change = 0; change <= round % 3; ++change) {
      const std::size_t at = random() % bytes.size();
      const char digits[] = {'0', '1', '9', '-', '{', ']', '"', ',', static_cast<char>(random() & 0xFFU)};
      bytes[at] = digits[random() % sizeof digits];
    }
    try {
      const eikon::Scene scene = load_scene(folder.write("a.glb", bytes));
      ++loaded;
      for (const eikon::Node& node : scene.nodes) ASSERT_LT(node.mesh, scene.meshes.size());
      for (const eikon::Mesh& mesh : scene.meshes) {
        for (const eikon::Primitive& primitive : mesh.primitives) {
          ASSERT_LT(primitive.material, scene.materials.size());
          ASSERT_EQ(primitive.indices.size() % 3, 0U);
          for (const std::uint32_t index : primitive.indices.list()) ASSERT_LT(index, primitive.positions_object.size());
          if (!primitive.normals_object.empty()) {
            ASSERT_EQ(primitive.normals_object.size(), primitive.positions_object.size());
          }
        }
      }
    } catch (const eikon::InputError& e) {
      ++refused;
      ASSERT_FALSE(contains(e.what(), "\n"));
    }
  }
  EXPECT_GT(loaded, 50);  // damage to names and numbers is harmless
  EXPECT_GT(refused, 100);
}

}  // namespace
