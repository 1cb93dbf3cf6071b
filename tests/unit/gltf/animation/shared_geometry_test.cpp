// SPDX-License-Identifier: Apache-2.0
// Poses of a file share the geometry that no pose changes.
#include "scene/scene_memory.h"
#include "support/animation_builder.h"
#include "support/paths.h"

namespace {

using eikon::MissingTangents;
using eikon::Primitive;
using eikon::Scene;
using scene_test::add_channel;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedShort;
using scene_test::target_of;

Scene load_at(const std::filesystem::path& path, double seconds, const std::shared_ptr<eikon::SceneMemory>& memory,
              const std::string& variant = {}, MissingTangents missing_tangents = MissingTangents::make) {
  return eikon::load_scene(path, {.variant = variant, .animation = {.animation = {}, .time_s = seconds}}, missing_tangents,
                           memory);
}

const Primitive& first_of(const Scene& scene) { return scene.meshes.at(0).primitives.at(0); }

bool share_geometry(const Primitive& a, const Primitive& b) { return a.positions_object.data() == b.positions_object.data(); }

/// A triangle with texture coordinates, which moves.
Builder moving_triangle() {
  Builder builder;
  builder.primitive()["attributes"]["TEXCOORD_0"] =
      builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  builder.primitive()["attributes"]["NORMAL"] =
      builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 1, 0, 0}});
  return builder;
}

void expect_same(const Primitive& a, const Primitive& b, const std::string& where) {
  EXPECT_EQ(a.positions_object, b.positions_object) << where;
  EXPECT_EQ(a.normals_object, b.normals_object) << where;
  EXPECT_EQ(a.uv[0], b.uv[0]) << where;
  EXPECT_EQ(a.uv[1], b.uv[1]) << where;
  EXPECT_EQ(a.colors, b.colors) << where;
  EXPECT_EQ(a.tangents_object, b.tangents_object) << where;
  EXPECT_EQ(a.indices, b.indices) << where;
  EXPECT_EQ(a.material, b.material) << where;
}

TEST(SharedGeometry, poses_of_a_file_have_one_copy_of_what_stays) {
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", moving_triangle().text());
  const Scene first = load_at(path, 0, nullptr), second = load_at(path, 0.5, first.memory);
  EXPECT_TRUE(share_geometry(first_of(first), first_of(second)));
  EXPECT_EQ(second.nodes.at(0).world_from_object[3].x, 0.5);
  first.memory->forget_primitives();
  EXPECT_FALSE(share_geometry(first_of(first), first_of(load_at(path, 1, first.memory))));
  EXPECT_FALSE(share_geometry(first_of(first), first_of(load_at(path, 1, nullptr))));
}

TEST(SharedGeometry, scenes_with_it_are_those_that_are_loaded_alone) {
  for (const char* name : {"bending_arm", "camera_path", "morphing_blob", "spinning_wheel", "walking_figure"}) {
    const std::filesystem::path path = std::filesystem::path(EIKON_SOURCE_DIR) / "scenes" / (std::string(name) + ".gltf");
    const Scene first = load_at(path, 0, nullptr), with = load_at(path, 0.3, first.memory), alone = load_at(path, 0.3, nullptr);
    EXPECT_EQ(with.warnings, alone.warnings) << name;
    ASSERT_EQ(with.meshes.size(), alone.meshes.size()) << name;
    for (std::size_t m = 0; m < with.meshes.size(); ++m) {
      ASSERT_EQ(with.meshes[m].primitives.size(), alone.meshes[m].primitives.size()) << name;
      for (std::size_t p = 0; p < with.meshes[m].primitives.size(); ++p)
        expect_same(with.meshes[m].primitives[p], alone.meshes[m].primitives[p], name);
    }
  }
}

TEST(SharedGeometry, morphed_triangles_are_of_their_pose) {
  Builder builder = moving_triangle();
  const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 0, 0, 0, 0, 0, 2, 0}, 3);
  builder.primitive()["targets"] = Json::array({{{"POSITION", up}}});
  add_channel(builder, 0, target_of(0, "weights"), {.times = {0, 1}, .values = {0, 1}, .type = "SCALAR"});
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", builder.text());
  const Scene first = load_at(path, 0, nullptr);
  EXPECT_EQ(first_of(load_at(path, 0.5, first.memory)).positions_object.at(2).y, 2);
  EXPECT_EQ(first_of(load_at(path, 1, first.memory)).positions_object.at(2).y, 3);
  EXPECT_EQ(first_of(load_at(path, 0, first.memory)).positions_object.at(2).y, 1);
}

TEST(SharedGeometry, morphed_triangles_are_joined_alike_in_every_pose) {
  for (const bool warns : {false, true}) {
    Builder builder = moving_triangle();
    const auto with = [&](const char* name, std::vector<float> values) {
      const std::size_t size = name == std::string("TEXCOORD_0") ? 2 : 3;
      values.insert(values.begin(), size, 9.0F);  // of a vertex that no triangle has
      builder.primitive()["attributes"][name] =
          builder.add(size == 2 ? "VEC2" : "VEC3", kFloat, values, values.size() / size);
    };
    with("POSITION", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    with("NORMAL", {0, 0, 1, 0, 0, 1, 0, 0, 1});
    with("TEXCOORD_0", {0, 0, 1, 0, 0, 1});
    std::vector<std::uint16_t> indices{3, 1, 2};
    if (warns) indices.push_back(1);  // a corner without a triangle
    builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedShort, indices, indices.size());
    const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0}, 4);
    builder.primitive()["targets"] = Json::array({{{"POSITION", up}}});
    add_channel(builder, 0, target_of(0, "weights"), {.times = {0, 1}, .values = {0.5F, 1}, .type = "SCALAR"});
    const scene_test::TemporaryFolder folder;
    const auto path = folder.write("scene.gltf", builder.text());
    const Scene first = load_at(path, 0, nullptr), second = load_at(path, 1, first.memory), alone = load_at(path, 1, nullptr);
    ASSERT_EQ(first_of(second).positions_object.size(), 3U);
    EXPECT_EQ(first_of(second).positions_object.at(0), glm::vec3(0, 3, 0)) << "the first corner of the triangle";
    expect_same(first_of(second), first_of(alone), "moved");
    EXPECT_EQ(second.warnings, alone.warnings);
    EXPECT_EQ(second.warnings.empty(), !warns);
  }
}

TEST(SharedGeometry, a_material_that_needs_tangents_gets_them) {
  Builder builder = moving_triangle();
  builder.json["materials"].push_back(
      {{"name", "brushed"}, {"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}}}});
  builder.json["extensions"]["KHR_materials_variants"] = Json::parse(R"({"variants": [{"name": "brushed"}]})");
  builder.json["extensionsUsed"] = {"KHR_materials_specular", "KHR_materials_variants", "KHR_materials_anisotropy"};
  builder.primitive()["extensions"]["KHR_materials_variants"] =
      Json::parse(R"({"mappings": [{"material": 1, "variants": [0]}]})");
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", builder.text());
  const Scene plain = load_at(path, 0, nullptr);
  EXPECT_TRUE(first_of(plain).tangents_object.empty());
  // Marked tangents are of no use to those who want them made.
  EXPECT_EQ(first_of(load_at(path, 0, plain.memory, "brushed", MissingTangents::mark)).tangents_object.at(0), glm::vec4(0));
  const Scene brushed = load_at(path, 0.5, plain.memory, "brushed");
  EXPECT_EQ(first_of(brushed).tangents_object.at(0), glm::vec4(1, 0, 0, -1));
  EXPECT_EQ(brushed.materials.at(first_of(brushed).material).name, "brushed");
  EXPECT_TRUE(share_geometry(first_of(brushed), first_of(load_at(path, 1, plain.memory, "brushed"))));
  EXPECT_TRUE(first_of(load_at(path, 1, plain.memory)).tangents_object.empty());
}

TEST(SharedGeometry, what_is_warned_of_is_warned_of_in_each_pose) {
  Builder builder = moving_triangle();
  // One of no length.
  const std::size_t normals = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 0, 0, 0, 1}, 3);
  builder.primitive()["attributes"]["NORMAL"] = normals;
  const scene_test::TemporaryFolder folder;
  const auto path = folder.write("scene.gltf", builder.text());
  const Scene first = load_at(path, 0, nullptr), second = load_at(path, 0.5, first.memory);
  EXPECT_FALSE(first.warnings.empty());
  EXPECT_EQ(first.warnings, second.warnings);
}

}  // namespace
