// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_counts.h"

#include <gtest/gtest.h>

namespace eikon {
namespace {

using Corners = std::array<glm::vec3, 3>;
const glm::vec3 kA(0, 0, 0), kB(2, 0, 0), kC(3, 1, 0), kD(1, 1, 0);  // a parallelogram, counter-clockwise

TEST(LightCounts, two_triangles_on_a_diagonal_are_one_parallelogram_whichever_corner_comes_first) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Corners all{kA, kB, kC}, others{kC, kD, kA};
      const auto at = [](const Corners& x, int n) {
        return Corners{x[std::size_t(n) % 3], x[std::size_t(n + 1) % 3], x[std::size_t(n + 2) % 3]};
      };
      const auto quad = parallelogram_of(at(all, i), at(others, k), 0);
      ASSERT_TRUE(quad);
      EXPECT_EQ(quad->p0, kB);
      EXPECT_EQ(quad->p1, kC) << "in the order of the first triangle, so that it faces the same way";
      EXPECT_EQ(quad->p2, kA);
      EXPECT_EQ(quad->p1 + quad->p2 - quad->p0, kD);
    }
}

TEST(LightCounts, other_pairs_are_none) {
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA, kC, glm::vec3(1, 1.01, 0)}, 0x1p-20)) << "a kite";
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA, kC, glm::vec3(1, 1, 0.01)}, 0x1p-20)) << "bent";
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA, kD, kC}, 1)) << "facing the other way";
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA, kC, kB}, 1)) << "two sides of one triangle";
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA, kB, kC}, 1)) << "twice the same";
  EXPECT_FALSE(parallelogram_of({kA, kB, kC}, {kA + glm::vec3(0, 0, 5), kC, kD}, 1)) << "one corner in common";
  EXPECT_TRUE(parallelogram_of({kA, kB, kC}, {kA, kC, kD + glm::vec3(1e-7F, 0, 0)}, 0x1p-20)) << "rounded";
}

Scene lamp(std::vector<glm::vec3> corners, std::vector<std::uint32_t> indices) {
  Scene scene;
  Primitive primitive;
  primitive.positions_object = std::move(corners);
  primitive.indices = std::move(indices);
  Material material;
  material.emission = glm::vec3(1);
  scene.materials.push_back(material);
  Mesh mesh;
  mesh.primitives.push_back(primitive);
  scene.meshes.push_back(mesh);
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  return scene;
}

TEST(LightCounts, the_parts_of_one_small_lamp_want_no_tree_but_those_of_a_large_one_or_of_two_do) {
  const Settings settings;
  Scene scene = lamp({kA, kB, kC, kD, {0, 0, 2}}, {0, 1, 2, 0, 3, 4, 1, 4, 3, 2, 0, 4});
  EXPECT_EQ(count_lights(scene, settings).places(), 4U);
  EXPECT_TRUE(count_lights(scene, settings).wants_tree()) << "there is nothing else";
  Scene room = scene;
  room.materials.emplace_back();
  Mesh walls;
  walls.primitives.push_back(scene.meshes[0].primitives[0]);
  walls.primitives[0].material = 1;
  for (glm::vec3& p : walls.primitives[0].positions_object) p *= 10.0F;
  room.meshes.push_back(walls);
  Node node;
  node.mesh = 1;
  room.nodes.push_back(node);
  EXPECT_FALSE(count_lights(room, settings).wants_tree());
  room.nodes.push_back(scene.nodes[0]);
  EXPECT_TRUE(count_lights(room, settings).wants_tree()) << "two lamps";
  room.nodes.pop_back();
  room.lights.emplace_back();
  EXPECT_TRUE(count_lights(room, settings).wants_tree()) << "a lamp and a point";
}

TEST(LightCounts, counts_each_light_once_and_every_instance) {
  Settings dark;
  dark.environment.radiance = glm::vec3(0);
  Scene scene = lamp({kA, kB, kC, kD}, {0, 1, 2, 0, 2, 3});
  LightCounts counts = count_lights(scene, dark);
  EXPECT_EQ(counts.placed, 2U);
  EXPECT_EQ(counts.pairs, 1U);
  EXPECT_TRUE(counts.is_one());
  Settings lit = dark;
  lit.environment.radiance = glm::vec3(0, 0, 1);
  EXPECT_FALSE(count_lights(scene, lit).is_one());
  scene.nodes.push_back(scene.nodes[0]);
  EXPECT_FALSE(count_lights(scene, dark).is_one());
  EXPECT_EQ(count_lights(scene, dark).pairs, 2U);
  scene.nodes.pop_back();
  scene.materials[0].emissive_texture = Texture{};
  EXPECT_EQ(count_lights(scene, dark).pairs, 0U) << "a texture may differ between the two";
  scene.materials[0].emissive_texture.reset();
  scene.materials[0].clearcoat_texture = Texture{};
  EXPECT_EQ(count_lights(scene, dark).pairs, 0U) << "so may a coat";
  scene.materials[0].clearcoat_texture.reset();
  scene.lights.emplace_back();
  EXPECT_FALSE(count_lights(scene, dark).is_one());
  scene.materials[0].emission = glm::vec3(0);
  EXPECT_TRUE(count_lights(scene, dark).is_one()) << "the point light alone";
  scene.lights.clear();
  EXPECT_TRUE(count_lights(scene, lit).is_one()) << "the sky alone";
  EXPECT_TRUE(count_lights(scene, dark).is_one()) << "none";
}

}  // namespace
}  // namespace eikon
