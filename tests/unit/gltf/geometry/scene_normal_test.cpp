// SPDX-License-Identifier: Apache-2.0
// Normals that are none: what takes their place.
#include <limits>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::warns;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

void set(Builder& builder, const std::string& name, const std::vector<float>& values) {
  builder.primitive()["attributes"][name] = builder.add("VEC3", kFloat, values, values.size() / 3);
}

TEST(SceneNormals, a_bad_normal_becomes_that_of_its_triangles_and_the_others_stay) {
  // Two triangles that share an edge, one upright in z and one in y of twice the area; vertex 4 is
  // in none with area.
  Builder builder;
  set(builder, "POSITION", std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -2, 5, 5, 5});
  builder.primitive()["indices"] =
      builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 2, 1, 0, 3, 4, 4, 0}, 9);
  set(builder, "NORMAL",
      std::vector<float>{0, 0, 0, kNotANumber, 0, 1, 3, 0, 0, 0, 0, 1, 0, std::numeric_limits<float>::infinity(), 0});
  const Scene scene = builder.load();
  const std::vector<glm::vec3> normals = scene.meshes.at(0).primitives.at(0).normals_object;
  ASSERT_EQ(normals.size(), 5U);
  const glm::vec3 mean = glm::normalize(glm::vec3(0, -2, 1));
  EXPECT_LT(glm::length(normals[0] - mean), 1e-6F);
  EXPECT_LT(glm::length(normals[1] - mean), 1e-6F);
  EXPECT_EQ(normals[2], glm::vec3(1, 0, 0));  // a direction is kept, whatever its length
  EXPECT_EQ(normals[3], glm::vec3(0, 0, 1));
  EXPECT_EQ(glm::length(normals[4]), 1.0F);
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "normals taken from the triangles: accessor"));
  EXPECT_TRUE(contains(scene.out_of_range[0], "element 0 is zero or not finite (3 of them)"));
}

TEST(SceneNormals, one_zero_or_non_finite_normal_is_named_and_leaves_the_others_alone) {
  for (const float bad : {0.0F, kNotANumber, std::numeric_limits<float>::infinity()}) {
    Builder builder;
    set(builder, "NORMAL", std::vector<float>{1, 0, 0, 0, 0, bad, 0, 1, 0});
    const Scene scene = builder.load();
    EXPECT_EQ(scene.meshes.at(0).primitives.at(0).normals_object,
              (std::vector<glm::vec3>{{1, 0, 0}, {0, 0, 1}, {0, 1, 0}}));
    EXPECT_TRUE(warns(scene, "accessor 2, element 1")) << bad;
  }
}

TEST(SceneNormals, a_mesh_with_bad_normals_only_is_flat) {
  Builder builder;
  set(builder, "NORMAL", std::vector<float>(9));
  const Scene scene = builder.load();
  EXPECT_TRUE(scene.meshes.at(0).primitives.at(0).normals_object.empty());
  EXPECT_TRUE(warns(scene, "normals dropped and made flat"));
}

}  // namespace
