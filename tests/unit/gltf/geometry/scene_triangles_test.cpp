// SPDX-License-Identifier: Apache-2.0
// Triangles of primitives: their modes, and accessors that several of them share.
#include <algorithm>

#include "support/gltf_builder.h"
#include "unit/gltf/geometry/accessors.h"

namespace {

using eikon::Primitive;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::leaves_out;
using scene_test::only_primitive;
using scene_test::warns;

TEST(SceneTriangles, primitives_of_the_same_accessors_share_their_geometry_and_keep_their_materials) {
  Builder builder;
  Json primitive = builder.primitive();
  builder.json["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
  Json& primitives = builder.json["meshes"][0]["primitives"] = Json::array();
  for (const int material : {0, 1, 0}) {
    primitive["material"] = material;
    primitives.push_back(primitive);
  }
  const Scene scene = builder.load();
  const std::vector<Primitive>& read = scene.meshes.at(0).primitives;
  ASSERT_EQ(read.size(), 3U);
  for (const Primitive& each : read) EXPECT_EQ(&each.positions_object[0], &read[0].positions_object[0]);
  EXPECT_EQ(read[1].material, 1U);
  EXPECT_EQ(read[2].material, 0U);
}

TEST(SceneTriangles, what_is_wrong_with_shared_accessors_is_said_of_each_primitive) {
  Builder builder;
  builder.primitive()["attributes"]["NORMAL"] = builder.add("VEC3", kFloat, std::vector<float>(9, 0.0F), 3);
  const Json primitive = builder.primitive();
  builder.json["meshes"][0]["primitives"].push_back(primitive);
  const Scene scene = builder.load();
  for (const char* user : {"primitive 0", "primitive 1"})
    EXPECT_EQ(std::ranges::count_if(scene.warnings, [&](const std::string& w) { return contains(w, user); }), 1)
        << user;
}

TEST(SceneTriangles, strips_turn_every_other_triangle_and_drop_those_that_only_lead_on) {
  Builder builder;
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0, 1, 2, 0};
  builder.primitive()["attributes"]["POSITION"] = builder.add("VEC3", kFloat, corners, 6);
  builder.primitive()["mode"] = 5;
  builder.primitive().erase("indices");
  Primitive read = only_primitive(builder.load());
  EXPECT_EQ(read.indices, (std::vector<std::uint32_t>{0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4}));
  // Two strips joined by corners that come twice; the second begins on an odd triangle and so is
  // turned once more.
  builder.primitive()["indices"] =
      builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 2, 2, 3, 3, 5, 4}, 8);
  read = only_primitive(builder.load());
  EXPECT_EQ(read.indices, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  for (std::size_t i = 0; i < read.indices.size(); i += 3) {
    const auto p = [&](std::size_t k) { return read.positions_object[read.indices[i + k]]; };
    EXPECT_GT(glm::cross(p(1) - p(0), p(2) - p(0)).z, -2.0F);
  }
}

TEST(SceneTriangles, fans_share_their_first_corner) {
  Builder builder;
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0};
  builder.primitive()["attributes"]["POSITION"] = builder.add("VEC3", kFloat, corners, 5);
  builder.primitive()["mode"] = 6;
  builder.primitive().erase("indices");
  EXPECT_EQ(only_primitive(builder.load()).indices, (std::vector<std::uint32_t>{1, 2, 0, 2, 3, 0, 3, 4, 0}));
  builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 1, 2, 0, 3}, 6);
  const Primitive read = only_primitive(builder.load());
  EXPECT_EQ(read.indices.size(), 3U);  // of (1, 1), (1, 2), (2, 0), (0, 3) only the second has three corners
  EXPECT_EQ(read.positions_object.size(), 3U);
}

TEST(SceneTriangles, strips_and_fans_of_fewer_than_three_corners_are_left_out_with_a_warning) {
  for (const int mode : {5, 6}) {
    Builder builder;
    builder.primitive()["mode"] = mode;
    builder.primitive()["indices"] = builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1}, 2);
    const Scene scene = builder.load();
    EXPECT_TRUE(scene.meshes.at(0).primitives.empty());
    EXPECT_TRUE(warns(scene, "2 corners are no whole number of triangles"));
  }
}

TEST(SceneTriangles, points_and_lines_are_left_out_by_name) {
  const char* names[] = {"POINTS", "LINES", "LINE_LOOP", "LINE_STRIP"};
  for (int mode = 0; mode < 4; ++mode) {
    Builder builder;
    builder.primitive()["mode"] = mode;
    const Scene scene = builder.load();
    EXPECT_TRUE(scene.meshes.at(0).primitives.empty());
    EXPECT_TRUE(leaves_out(scene, std::string("primitives of mode ") + names[mode], "mesh 'flat'"));
  }
}

}  // namespace
