// SPDX-License-Identifier: Apache-2.0
// What good files give.
#include <cmath>

#include "scene_builder.h"

namespace {

using eikon::load_scene;
using eikon::Scene;
using scene_test::Builder;
using scene_test::Json;
using scene_test::leaves_out;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::warns;

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
    const eikon::Primitive& primitive = scene.meshes[0].primitives[0];
    EXPECT_EQ(primitive.positions_object,
              (std::vector<glm::vec3>{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}));
    EXPECT_EQ(primitive.indices, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_TRUE(primitive.normals_object.empty());
    EXPECT_EQ(scene.nodes.size(), 1U);
    EXPECT_EQ(scene.nodes[0].name, "triangle");
    EXPECT_EQ(scene.materials.size(), 1U);
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(0.5F, 0.25F, 0.125F));
    EXPECT_TRUE(scene.unsupported.empty());
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.hash.size(), 16U);
  }
}

}  // namespace
