// SPDX-License-Identifier: Apache-2.0
// Which solids have ranks, and when anything asks for them.

#include <gtest/gtest.h>

#include "core/error.h"
#include "pack/materials/material_traits.h"
#include "pack/pack.h"

namespace eikon {
namespace {

Material solid(std::optional<std::int32_t> priority = {}) {
  Material m;
  m.metallic = 0;
  m.transmission = 1;
  m.solid = true;
  m.medium_priority = priority;
  return m;
}

/// Each of them on a triangle of its own.
Scene shown(const std::vector<Material>& materials) {
  Scene scene;
  scene.path = "some.gltf";
  scene.materials = materials;
  for (std::uint32_t i = 0; i < materials.size(); ++i) {
    Primitive p;
    p.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    p.indices = {0, 1, 2};
    p.material = i;
    scene.meshes.push_back({"", {p}});
    scene.nodes.emplace_back().mesh = i;
  }
  return scene;
}

Features features_of_scene(const Scene& scene) { return {scene, Settings{}}; }

TEST(MediumRanks, go_by_priority_then_by_the_place_in_the_file) {
  Material thin = solid(9), metal = solid(9);
  thin.solid = false;
  metal.metallic = 1;
  Scene scene = shown({solid(2), thin, solid(), solid(-1), metal, solid(2), solid(0), solid(1000000)});
  EXPECT_EQ(medium_ranks(scene), (std::vector<std::uint32_t>{4, 0, 2, 1, 0, 5, 3, 6}));
  scene.nodes.erase(scene.nodes.begin());  // what no node shows has none
  EXPECT_EQ(medium_ranks(scene), (std::vector<std::uint32_t>{0, 0, 2, 1, 0, 4, 3, 5}));
}

TEST(MediumRanks, solids_without_a_mesh_have_them_too) {
  Scene scene = shown({});
  scene.materials = {Material{}, solid(1)};
  scene.shapes.emplace_back().material = 1;
  EXPECT_EQ(medium_ranks(scene), (std::vector<std::uint32_t>{0, 1}));
}

TEST(MediumRanks, of_256_solids_there_is_one_too_many) {
  std::vector<Material> many(255, solid(1));
  EXPECT_EQ(medium_ranks(shown(many)).back(), 255U);
  many.push_back(solid(1));
  try {
    (void)medium_ranks(shown(many));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "some.gltf: mediumPriority orders 255 solids at most, and materials of 256 are shown; let "
                 "some share one, or leave the priorities out");
  }
  for (Material& m : many) m.medium_priority.reset();  // nothing is asked of them then
  const Scene scene = shown(many);
  EXPECT_NO_THROW(pack_scene(scene, features_of_scene(scene), Settings{}));
}

TEST(MediumRanks, are_asked_for_where_a_solid_says_mediumPriority) {
  Material opaque;
  opaque.medium_priority = 3;
  EXPECT_FALSE(features_of_scene(shown({solid(), solid()})).has(Feature::nested_media));
  EXPECT_FALSE(features_of_scene(shown({solid(), opaque})).has(Feature::nested_media));
  const Scene scene = shown({solid(), solid(0)});
  const Features features = features_of_scene(scene);
  EXPECT_TRUE(features.has(Feature::nested_media));
  EXPECT_FALSE(features.has(Feature::absorption));
  EXPECT_EQ(path_state_layout(features, true).field.count("medium"), 1U);
  EXPECT_EQ(path_state_layout(features_of_scene(shown({solid(), solid()})), true).field.count("medium"), 0U);
  const PackedScene packed = pack_scene(scene, features, Settings{});
  EXPECT_EQ(packed.material_extensions[0].medium_rank, 1U);
  EXPECT_EQ(packed.material_extensions[1].medium_rank, 2U);
  EXPECT_EQ(packed.material_extensions[1].medium_of_rank, 1U);
}

}  // namespace
}  // namespace eikon
