// SPDX-License-Identifier: Apache-2.0
// Meshes that are freed while they are packed give the same records.
#include "pack/pack.h"

#include <gtest/gtest.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

namespace eikon {
namespace {

/// Two meshes in three nodes; the first mesh is shown twice, once mirrored, with another between.
Scene instanced_scene() {
  Scene scene;
  Material mapped;
  TextureImage image;
  image.width = image.height = 1;
  image.rgba8 = {0xffff8080U};
  scene.images.push_back(image);
  mapped.normal_texture = Texture{};
  scene.materials = {Material{}, mapped};
  Primitive leaf;
  leaf.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5F}, {1, 1, 0}};
  leaf.normals_object = {{0, 0, 1}, {0, 0.6F, 0.8F}, {0.6F, 0, 0.8F}, {0, 0, 1}};
  leaf.uv[0] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  leaf.tangents_object = {{1, 0, 0, 1}, {1, 0, 0, -1}, {0.8F, 0, -0.6F, 1}, {1, 0, 0, 1}};
  leaf.colors = {{1, 0, 0, 1}, {0, 1, 0, 0.5F}, {0, 0, 1, 1}, {1, 1, 1, 1}};
  leaf.indices = {0, 1, 2, 1, 3, 2};
  leaf.material = 1;
  Primitive plain;
  plain.positions_object = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  plain.indices = {0, 1, 2};
  scene.meshes = {{"leaves", {leaf, plain}}, {"plain", {plain}}};
  scene.nodes.resize(3);
  scene.nodes[1].mesh = 1;
  scene.nodes[2].world_from_object =
      glm::rotate(glm::scale(glm::dmat4(1.0), {-2.0, 1.0, 3.0}), 0.3, glm::dvec3(0, 1, 0));
  scene.nodes[2].mirrored = true;
  return scene;
}

template <class T>
bool same_bytes(const DeviceVector<T>& a, const DeviceVector<T>& b) {
  return a.size() == b.size() && !a.empty() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(Pack, meshes_that_are_freed_give_the_same_records) {
  Scene scene = instanced_scene();
  const Settings settings;
  const Features features(scene, settings);
  const PackedScene kept = pack_scene(scene, features, settings);
  EXPECT_EQ(scene.meshes[0].primitives[0].positions_object.size(), 4U);
  const PackedScene packed = pack_and_release(scene, features, settings);
  EXPECT_EQ(packed.triangles.size(), 7U);
  EXPECT_TRUE(same_bytes(packed.triangles, kept.triangles));
  EXPECT_TRUE(same_bytes(packed.normals, kept.normals));
  EXPECT_TRUE(same_bytes(packed.tangents, kept.tangents));
  EXPECT_TRUE(same_bytes(packed.colors, kept.colors));
  EXPECT_EQ(packed.bounds.lo, kept.bounds.lo);
  EXPECT_EQ(packed.bounds.hi, kept.bounds.hi);
  for (const Mesh& mesh : scene.meshes)
    for (const Primitive& primitive : mesh.primitives) {
      EXPECT_EQ(primitive.positions_object.capacity() + primitive.normals_object.capacity() +
                    primitive.tangents_object.capacity() + primitive.colors.capacity() + primitive.uv[0].capacity() +
                    primitive.indices.bytes(),
                0U);
    }
  EXPECT_EQ(scene.meshes[0].primitives[0].material, 1U);
}

TEST(Pack, a_shared_scene_keeps_alive_what_it_refers_to) {
  auto scene = std::make_shared<Scene>(instanced_scene());
  const Settings settings;
  const Features features(*scene, settings);
  std::shared_ptr<PackedScene> packed = share(pack_scene(*scene, features, settings), scene);
  const std::weak_ptr<Scene> seen = scene;
  scene.reset();
  ASSERT_FALSE(seen.expired());
  ASSERT_EQ(packed->texels.size(), 2U) << "a table, and the picture of the scene";
  EXPECT_EQ(packed->texels[1].data(), seen.lock()->images[0].rgba8.data());
  std::shared_ptr<const PackedScene> other = packed;
  packed.reset();
  EXPECT_FALSE(seen.expired()) << "another one shares it";
  other.reset();
  EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace eikon
