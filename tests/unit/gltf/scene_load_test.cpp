// SPDX-License-Identifier: Apache-2.0
// What good files give, and what is done about the odd ones.
#include <clocale>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "io/xxhash64.h"
#include "support/comma_locale.h"
#include "support/gltf_builder.h"

namespace {

using eikon::load_scene;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedInt;
using scene_test::kUnsignedShort;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::warns;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

const eikon::Primitive& only_primitive(const Scene& scene) { return scene.meshes.at(0).primitives.at(0); }

TEST(SceneLoad, gltf_with_embedded_data_glb_and_external_buffer_give_the_same_triangle) {
  const Builder builder;
  const TemporaryFolder folder;
  Builder external = builder;
  external.json["buffers"] = {{{"byteLength", builder.buffer.size()}, {"uri", "data%20file.bin"}}};
  folder.write("data file.bin", builder.buffer);
  for (const auto& path : {folder.write("a.gltf", builder.text()), folder.write("b.glb", builder.glb_bytes()),
                           folder.write("c.gltf", external.text())}) {
    const Scene scene = load_scene(path);
    ASSERT_EQ(scene.meshes.size(), 1U) << path;
    ASSERT_EQ(scene.meshes[0].primitives.size(), 1U);
    const eikon::Primitive& primitive = only_primitive(scene);
    EXPECT_EQ(primitive.positions_object,
              (std::vector<glm::vec3>{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}));
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_TRUE(primitive.normals_object.empty());
    ASSERT_EQ(scene.nodes.size(), 1U);
    EXPECT_EQ(scene.nodes[0].name, "triangle");
    ASSERT_EQ(scene.materials.size(), 1U);
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(0.5F, 0.25F, 0.125F));
    EXPECT_TRUE(scene.unsupported.empty());
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.hash.size(), 16U);
    EXPECT_EQ(scene.path, path);
  }
}

TEST(SceneLoad, indices_of_one_two_and_four_bytes_and_none_give_the_same_triangles) {
  Builder u8, u32, none;
  u8.primitive()["indices"] = u8.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{2, 0, 1}, 3);
  u32.primitive()["indices"] = u32.add("SCALAR", kUnsignedInt, std::vector<std::uint32_t>{2, 0, 1}, 3);
  none.primitive().erase("indices");
  EXPECT_EQ(only_primitive(u8.load()).indices, (std::vector<std::uint32_t>{2, 0, 1}));
  EXPECT_EQ(only_primitive(u32.load()).indices, (std::vector<std::uint32_t>{2, 0, 1}));
  EXPECT_EQ(only_primitive(none.load()).indices, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST(SceneLoad, primitives_that_share_vertices_get_only_those_they_use) {
  Builder builder;
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 6, 5, 5, 5, 6, 5};
  const std::size_t shared = builder.add("VEC3", kFloat, corners, 6);
  builder.primitive()["attributes"]["POSITION"] = shared;
  builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{5, 3, 4}, 3);
  const eikon::Primitive read = only_primitive(builder.load());
  EXPECT_EQ(read.positions_object.size(), 3U);
  EXPECT_EQ(read.positions_object[read.indices[0]], glm::vec3(5, 6, 5));
  EXPECT_EQ(read.positions_object[read.indices[1]], glm::vec3(5, 5, 5));
  EXPECT_EQ(read.positions_object[read.indices[2]], glm::vec3(6, 5, 5));
}

TEST(SceneLoad, interleaved_and_offset_attributes_are_read_by_their_stride) {
  Builder builder;
  // Position, padding, normal; a bufferView with a stride, accessors with offsets.
  std::vector<float> interleaved;
  for (int i = 0; i < 3; ++i) {
    const auto x = static_cast<float>(i);
    interleaved.insert(interleaved.end(), {x, x * x, 1, 99, 0, 0, 2});
  }
  const std::size_t view = builder.add_view(interleaved);
  builder.json["bufferViews"][view]["byteStride"] = 28;
  for (const std::size_t offset : {0U, 16U}) {
    builder.json["accessors"].push_back(
        {{"bufferView", view}, {"byteOffset", offset}, {"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
  }
  const std::size_t last = builder.json["accessors"].size() - 1;
  builder.primitive()["attributes"] = {{"POSITION", last - 1}, {"NORMAL", last}};
  const Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).positions_object[2], glm::vec3(2, 4, 1));
  EXPECT_EQ(only_primitive(scene).normals_object[2], glm::vec3(0, 0, 1));
}

TEST(SceneLoad, sparse_accessors_replace_the_elements_they_name) {
  Builder builder;
  const std::size_t indices = builder.add_view(std::vector<std::uint16_t>{1, 2}),
                    values = builder.add_view(std::vector<float>{7, 0, 0, 0, 8, 0});
  const Json sparse = {{"count", 2},
                       {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
                       {"values", {{"bufferView", values}}}};
  Builder over_zeros = builder;
  builder.json["accessors"][0]["sparse"] = sparse;
  EXPECT_EQ(only_primitive(builder.load()).positions_object,
            (std::vector<glm::vec3>{glm::vec3(0, 0, 0), glm::vec3(7, 0, 0), glm::vec3(0, 8, 0)}));
  over_zeros.json["accessors"][0] = {{"componentType", kFloat}, {"count", 4}, {"type", "VEC3"}, {"sparse", sparse}};
  over_zeros.primitive()["indices"] = over_zeros.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{3, 1, 2}, 3);
  EXPECT_EQ(only_primitive(over_zeros.load()).positions_object[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(only_primitive(over_zeros.load()).positions_object[2], glm::vec3(0, 8, 0));
}

TEST(SceneLoad, normals_are_made_unit_even_where_their_squares_overflow_or_vanish) {
  Builder builder;
  const std::vector<float> normals{0, 0, 3, 1e30F, 0, 1e30F, 0, 1e-30F, 0};
  builder.primitive()["attributes"]["NORMAL"] = builder.add("VEC3", kFloat, normals, 3);
  const Scene scene = builder.load();
  ASSERT_EQ(only_primitive(scene).normals_object.size(), 3U);
  EXPECT_EQ(only_primitive(scene).normals_object[0], glm::vec3(0, 0, 1));
  EXPECT_NEAR(static_cast<double>(only_primitive(scene).normals_object[1].x), std::sqrt(0.5), 1e-7);
  EXPECT_EQ(only_primitive(scene).normals_object[2], glm::vec3(0, 1, 0));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneLoad, G11_degenerate_triangles_survive_and_leave_the_rest_alone) {
  Builder builder;
  // A good triangle, then repeated indices, three equal corners, and three corners in a line.
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0};
  builder.primitive()["attributes"]["POSITION"] = builder.add("VEC3", kFloat, corners, 4);
  const std::vector<std::uint16_t> indices{0, 1, 2, 0, 0, 1, 2, 2, 2, 0, 1, 3};
  builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedShort, indices, indices.size());
  const Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).indices, (std::vector<std::uint32_t>(indices.begin(), indices.end())));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneLoad, G12_nan_infinite_and_huge_positions_name_accessor_and_element) {
  for (const float bad : {kNan, kInf, -kInf, 1e38F, -1.2e12F}) {
    Builder builder;
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, bad, 0};
    builder.primitive()["attributes"]["POSITION"] = builder.add("VEC3", kFloat, corners, 3);
    builder.json["accessors"].back()["name"] = "corners";
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, "accessor 2 'corners', element 2: y = "));
  }
}

TEST(SceneLoad, G12_positions_that_leave_the_range_by_their_node_name_it) {
  Builder builder;
  builder.node()["scale"] = {1e13, 1, 1};
  const std::string message = message_of([&] { builder.load(); });
  EXPECT_TRUE(contains(message, "node 'triangle'"));
  EXPECT_TRUE(contains(message, "vertex 1"));

  // A vertex far out in a mesh and a node that brings it back: legal, whatever the bound of the
  // whole says.
  Builder back;
  back.primitive()["attributes"]["POSITION"] =
      back.add("VEC3", kFloat, std::vector<float>{1e12F, 0, 0, 1.000001e12F, 0, 0, 1e12F, 1, 0}, 3);
  back.node()["translation"] = {-1e12, 0, 0};
  EXPECT_EQ(back.load().nodes.size(), 1U);
}

TEST(SceneLoad, G15_ten_thousand_equal_triangles_one_and_none_load) {
  Builder many;
  std::vector<std::uint16_t> indices;
  for (int i = 0; i < 10000; ++i) indices.insert(indices.end(), {0, 1, 2});
  many.primitive()["indices"] = many.add("SCALAR", kUnsignedShort, indices, indices.size());
  EXPECT_EQ(only_primitive(many.load()).indices.size(), 30000U);
  EXPECT_EQ(only_primitive(Builder().load()).indices.size(), 3U);

  Builder empty_mesh;
  empty_mesh.primitive()["indices"] = empty_mesh.add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{}, 0);
  const Scene none = empty_mesh.load();
  EXPECT_TRUE(none.meshes.at(0).primitives.empty());
  EXPECT_TRUE(eikon::world_bounds(none).empty());

  const TemporaryFolder folder;
  const Scene nothing = load_scene(folder.write("nothing.gltf", R"({"asset": {"version": "2.0"}})"));
  EXPECT_TRUE(nothing.nodes.empty());
  EXPECT_TRUE(nothing.meshes.empty());
}

TEST(SceneLoad, corners_beyond_the_last_whole_triangle_are_left_out_with_a_warning) {
  Builder builder;
  builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{0, 1, 2, 0, 1}, 5);
  const Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).indices.size(), 3U);
  EXPECT_TRUE(warns(scene, "mesh 'flat', primitive 0"));
}

TEST(SceneLoad, meshes_that_no_node_uses_are_not_read) {
  Builder builder;
  const std::size_t bad = builder.add("VEC3", kFloat, std::vector<float>{kNan, 0, 0}, 1);
  builder.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", bad}}}}}}});
  EXPECT_EQ(builder.load().meshes.size(), 1U);
}

TEST(SceneLoad, a_mesh_used_twice_is_kept_once) {
  Builder builder;
  builder.json["nodes"].push_back({{"mesh", 0}, {"translation", {3, 0, 0}}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.meshes.size(), 1U);
  ASSERT_EQ(scene.nodes.size(), 2U);
  EXPECT_EQ(scene.nodes[1].mesh, 0U);
  EXPECT_EQ(scene.nodes[1].world_from_object[3].x, 3.0);
}

TEST(SceneLoad, hash_follows_every_byte_of_the_file_and_of_its_buffers) {
  Builder builder;
  builder.json["buffers"] = {{{"byteLength", builder.buffer.size()}, {"uri", "a.bin"}}};
  const TemporaryFolder folder;
  folder.write("a.bin", builder.buffer);
  const auto path = folder.write("a.gltf", builder.text());
  const Scene first = load_scene(path);
  EXPECT_EQ(first.hash, load_scene(path).hash);
  EXPECT_EQ(first.file_bytes, builder.text().size() + builder.buffer.size());
  std::string changed = builder.buffer;
  changed[changed.size() - 6] = 1;  // an index
  folder.write("a.bin", changed);
  const Scene other_buffer = load_scene(path);
  EXPECT_NE(first.hash, other_buffer.hash);
  folder.write("a.gltf", builder.text() + " ");
  EXPECT_NE(other_buffer.hash, load_scene(path).hash);
}

TEST(SceneLoad, xxhash64_agrees_with_the_reference_implementation) {
  // Values of python-xxhash 3 for the bytes (7 i + 3) mod 256.
  struct Row {
    std::size_t size;
    std::uint64_t seed, hash;
  };
  std::vector<std::byte> bytes(101);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>((i * 7 + 3) & 0xFFU);
  constexpr std::uint64_t kSeed = 0x9E3779B97F4A7C15U;
  for (const Row& row : std::vector<Row>{{0, 0, 0xEF46DB3751D8E999U},
                                         {1, 0, 0x1F25C8D0BC1F4BB6U},
                                         {3, 0, 0x31D2363F52E564C9U},
                                         {4, 0, 0x9BB64B7D66EE9FDAU},
                                         {7, 0, 0x9A7B149959CE60D8U},
                                         {8, 0, 0xDAB99D95C6F90092U},
                                         {31, 0, 0xA2AA5F33CC4A6119U},
                                         {32, 0, 0x23C3C17EF790FD97U},
                                         {33, 0, 0x50A7CFC7BA588784U},
                                         {64, 0, 0x0EB64B3EF6EEB01FU},
                                         {101, 0, 0xBAD4D3BF033BDA4CU},
                                         {101, kSeed, 0x9A5F95077EAECB78U},
                                         {13, kSeed, 0x8911D13E1DEE1A36U}}) {
    EXPECT_EQ(eikon::xxhash64(std::span(bytes).first(row.size), row.seed), row.hash) << row.size;
  }
}

TEST(SceneLoad, environment_comes_from_the_scene_before_the_document) {
  Builder builder;
  EXPECT_FALSE(builder.load().environment.has_value());
  builder.json["extras"]["environment"]["radiance"] = {1, 1, 1};
  EXPECT_EQ(builder.load().environment->radiance, glm::vec3(1, 1, 1));
  builder.json["scenes"][0]["extras"]["environment"]["radiance"] = {0.5, 0.25, 2};
  EXPECT_EQ(builder.load().environment->radiance, glm::vec3(0.5F, 0.25F, 2));
}

TEST(SceneLoad, cameras_keep_their_lens_and_a_pose_without_the_scale_of_their_node) {
  Builder builder;
  builder.json["cameras"] = {{{"name", "eye"},
                              {"type", "perspective"},
                              {"perspective", {{"yfov", 0.8}, {"aspectRatio", 1.5}, {"znear", 0.1}}}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"translation", {1, 2, 3}}, {"scale", {2, 3, -4}}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.cameras.size(), 1U);
  EXPECT_EQ(scene.cameras[0].name, "eye");
  EXPECT_EQ(scene.cameras[0].yfov_rad, 0.8);
  EXPECT_EQ(scene.cameras[0].aspect, 1.5);
  const glm::dmat4& pose = scene.cameras[0].world_from_camera;
  EXPECT_EQ(pose[3], glm::dvec4(1, 2, 3, 1));
  EXPECT_EQ(pose[2], glm::dvec4(0, 0, -1, 0));
  EXPECT_EQ(pose[1], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(pose[0], glm::dvec4(-1, 0, 0, 0));

  builder.node(1)["scale"] = {1, 0, 1};
  EXPECT_TRUE(builder.load().cameras.empty());
  EXPECT_TRUE(warns(builder.load(), "camera 'eye'"));

  builder.node(1)["scale"] = {1, 1, 1};
  builder.node(1)["translation"] = {0, 0, 1e60};
  EXPECT_TRUE(contains(message_of([&] { (void)builder.load(); }), "camera 'eye': lies at z = 1e+60, beyond 2^40 m"));
  builder.node(1)["translation"] = {0, 0, 1};
  builder.json["cameras"][0]["perspective"]["aspectRatio"] = 1e300;
  EXPECT_TRUE(contains(message_of([&] { (void)builder.load(); }), "'aspectRatio' 1e+300 is not from 1e-06 to 1e+06"));
}

TEST(SceneLoad, orthographic_cameras_keep_half_their_height_and_their_aspect) {
  Builder builder;
  builder.json["cameras"] = {
      {{"name", "plan"}, {"type", "orthographic"}, {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0.1}}}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"scale", {9, 9, 9}}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  for (const double sign : {1.0, -1.0}) {
    builder.json["cameras"][0]["orthographic"]["xmag"] = sign * 3;
    const Scene scene = builder.load();
    ASSERT_EQ(scene.cameras.size(), 1U);
    EXPECT_EQ(scene.cameras[0].projection, eikon::Projection::orthographic);
    EXPECT_EQ(scene.cameras[0].ymag_m, 2.0);  // the scale of its node does not count
    EXPECT_EQ(scene.cameras[0].aspect, 1.5);
    EXPECT_EQ(warns(scene, "camera 'plan': negative xmag or ymag"), sign < 0);
  }
}

// Puts the old locale back however the test ends.
class LocaleGuard {
 public:
  LocaleGuard() : old_(std::setlocale(LC_ALL, nullptr)) {}
  ~LocaleGuard() { std::setlocale(LC_ALL, old_.c_str()); }
  LocaleGuard(const LocaleGuard&) = delete;
  LocaleGuard& operator=(const LocaleGuard&) = delete;

 private:
  std::string old_;
};

TEST(SceneLoad, N14_a_locale_with_decimal_comma_changes_nothing) {
  Builder builder;
  builder.node()["translation"] = {0.125, 1.5, -2.75};
  const Scene expected = builder.load();
  const std::string text = builder.text();
  const eikon::test::CommaLocale comma;
  if (!comma.made()) GTEST_SKIP() << "no locale with a decimal comma can be made";
  const LocaleGuard guard;
  setenv("LOCPATH", comma.folder().c_str(), 1);
  ASSERT_NE(std::setlocale(LC_ALL, eikon::test::CommaLocale::name()), nullptr);
  ASSERT_EQ(std::localeconv()->decimal_point[0], ',');
  const TemporaryFolder folder;
  const Scene scene = load_scene(folder.write("comma.gltf", text));
  EXPECT_EQ(scene.nodes.at(0).world_from_object, expected.nodes.at(0).world_from_object);
  EXPECT_EQ(scene.materials.at(0).base_color, expected.materials.at(0).base_color);
}

}  // namespace
