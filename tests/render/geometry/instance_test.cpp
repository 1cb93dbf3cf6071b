// SPDX-License-Identifier: Apache-2.0
// Meshes with many instances: the picture has the same bits whether they are stored once or for
// each instance.
#include <random>

#include "pack/geometry/instanced_meshes.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

/// The room with balls that have normals of their own, and boxes that have none, with many
/// instances: turned, stretched, some mirrored.
std::pair<Scene, Settings> crowded_room() {
  auto [scene, settings] = room(41, 27, 8);
  settings.aovs = {"albedo", "normal", "depth", "id"};
  std::mt19937 random(3);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Primitive box;
  add_box(box, glm::vec3(-0.05F), glm::vec3(0.05F), false);
  Material shiny;
  shiny.metallic = 1;
  shiny.roughness = 0.3F;
  add_mesh(scene, "boxes", std::move(box), lambert({0.2F, 0.7F, 0.3F}));
  add_mesh(scene, "balls", sphere(glm::vec3(0.0F), 0.06F, 6, false, true), shiny);
  const auto balls = std::uint32_t(scene.meshes.size() - 1), boxes = balls - 1;
  for (int i = 0; i < 40; ++i) {
    Node node;
    node.mesh = i % 2 == 0 ? balls : boxes;
    const double mirror = i % 5 == 4 ? -1 : 1;
    node.world_from_object =
        glm::translate(glm::dmat4(1), {uniform(-0.9, 0.9), uniform(-0.9, 0.9), uniform(-0.9, 0.9)}) *
        glm::rotate(glm::dmat4(1), uniform(0, 6), glm::normalize(glm::dvec3(uniform(-1, 1), uniform(-1, 1), 0.5))) *
        glm::scale(glm::dmat4(1), {mirror * uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2)});
    node.mirrored = mirror < 0;
    scene.nodes.push_back(node);
  }
  return {std::move(scene), settings};
}

std::vector<Execution> two_level_ways() {
  std::vector<Execution> ways;
  for (const Execution& way : each_way_to_trace()) {
    if (way.accel != "bvh" || !has_two_levels(way.layout)) continue;
    ways.push_back(way);
    ways.back().instances = InstanceMode::two_level;
  }
  return ways;
}

TEST(Instances, G19_G17_stored_once_or_for_each_instance_the_picture_has_the_same_bits) {
  const auto [scene, settings] = crowded_room();
  Execution flat;
  flat.instances = InstanceMode::flat;
  const Film expected = film_of(scene, settings, flat);
  for (const Execution& way : two_level_ways()) {
    InstanceChoice choice;
    (void)features_of(scene, settings, way, &choice);
    ASSERT_TRUE(choice.two_level);
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, way)))
        << way.layout << ", " << way.lanes.value_or(0) << " lanes";
  }
}

TEST(Instances, G19_exact_places_are_hit_where_the_baked_mesh_is_to_the_bit) {
  // Moves by eighths, scales by powers of two, exchanged axes: places of corners without rounding.
  Scene once, baked;
  const Primitive ball = sphere(glm::vec3(0.0F), 1, 6, false);
  Primitive exact = ball;
  for (glm::vec3& p : exact.positions_object) p = glm::round(p * 256.0F) / 256.0F;
  Settings settings = settings_for(48, 32, 4);
  settings.environment.radiance = glm::vec3(1);
  settings.camera = look_at_camera({3, 4, 12}, {0, 0, 0}, {0, 1, 0}, 0.9);
  settings.aovs = {"depth"};
  settings.max_depth = 1;
  add_mesh(once, "ball", exact, lambert(0.6F));
  once.nodes.clear();
  for (int i = 0; i < 20; ++i) {
    Node node;
    const double s = std::ldexp(1.0, i % 3 - 1);
    const int turn = i % 3;
    for (int k = 0; k < 3; ++k) {
      node.world_from_object[k] = glm::dvec4(0);
      node.world_from_object[k][(k + turn) % 3] = s;
    }
    node.world_from_object[3] = glm::dvec4((i % 5 - 2) * 2.125, (i / 5 - 2) * 2.375, (i % 4) * 0.625, 1);
    once.nodes.push_back(node);
    Primitive placed = exact;
    for (glm::vec3& p : placed.positions_object) p = glm::vec3(node.world_from_object * glm::dvec4(p, 1));
    add_mesh(baked, "ball", std::move(placed), lambert(0.6F));
  }
  Execution two_level;
  two_level.instances = InstanceMode::two_level;
  // Hits, that is: normals of instances come from floats, those of other triangles from doubles,
  // and may differ in the last bit.
  const Film expected = film_of(baked, settings), found = film_of(once, settings, two_level);
  for (std::uint32_t y = 0; y < settings.height; ++y)
    for (std::uint32_t x = 0; x < settings.width; ++x)
      for (const std::uint32_t channel : {3U, 4U})
        ASSERT_EQ(expected.mean(x, y, channel), found.mean(x, y, channel)) << "pixel " << x << "," << y;
}

TEST(Instances, a_single_instance_is_stored_as_it_is_and_lights_and_glass_for_each_instance) {
  auto [scene, settings] = crowded_room();
  for (const char* name : {"lamp", "ball"}) {
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
      if (scene.meshes[m].name != name) continue;
      Node again;
      again.mesh = m;
      again.world_from_object = glm::translate(glm::dmat4(1), {0.1, -0.3, 0.1});
      scene.nodes.push_back(again);
      if (m + 1 < scene.meshes.size() && std::string(name) == "ball") {
        Material& glass = scene.materials[scene.meshes[m].primitives[0].material];
        glass.transmission = 1, glass.solid = true, glass.specular = 1;
      }
    }
  }
  const InstancedMeshes instanced = find_instanced_meshes(scene);
  for (const InstancedMesh& mesh : instanced.meshes) {
    EXPECT_NE(scene.meshes[mesh.mesh].name, "lamp");
    EXPECT_NE(scene.meshes[mesh.mesh].name, "ball");
  }
  EXPECT_EQ(instanced.meshes.size(), 4U);  // boxes and balls, and those that are mirrored
  Execution flat, two_level;
  flat.instances = InstanceMode::flat;
  two_level.instances = InstanceMode::two_level;
  EXPECT_TRUE(same_film(film_of(scene, settings, flat), film_of(scene, settings, two_level)));
}

TEST(Instances, two_levels_come_where_they_save_much_and_trees_can_have_them) {
  Scene scene;
  add_mesh(scene, "ball", sphere(glm::vec3(0.0F), 1, 40, false, true), lambert(0.5F));
  const Settings settings = settings_for(8, 8, 1);
  const auto choice = [&](const std::string& accel, const std::string& layout, InstanceMode mode) {
    Execution execution;
    execution.accel = accel, execution.layout = layout, execution.instances = mode;
    InstanceChoice chosen;
    const Features features = features_of(scene, settings, execution, &chosen);
    EXPECT_EQ(features.has(Feature::instance), chosen.two_level);
    return chosen;
  };
  const InstanceChoice alone = choice("bvh", "", InstanceMode::two_level);
  EXPECT_FALSE(alone.two_level);
  EXPECT_TRUE(alone.refused);
  scene.nodes.push_back(scene.nodes[0]);
  EXPECT_FALSE(choice("bvh", "", InstanceMode::automatic).two_level);  // little to save
  EXPECT_TRUE(choice("bvh", "", InstanceMode::two_level).two_level);
  for (int i = 0; i < 100; ++i) scene.nodes.push_back(scene.nodes[0]);
  const InstanceChoice many = choice("bvh", "", InstanceMode::automatic);
  EXPECT_TRUE(many.two_level);
  EXPECT_GT(many.flat_bytes, 50 * many.two_level_bytes);
  EXPECT_FALSE(choice("bvh", "", InstanceMode::flat).two_level);
  for (const char* layout : {"bvh4", "cwbvh"}) {
    EXPECT_FALSE(choice("bvh", layout, InstanceMode::automatic).two_level);
    const InstanceChoice refused = choice("bvh", layout, InstanceMode::two_level);
    EXPECT_TRUE(refused.refused && !refused.two_level);
    EXPECT_EQ(refused.why, std::string("--layout ") + layout + " has one level");
  }
  EXPECT_EQ(choice("grid", "", InstanceMode::two_level).why, "--accel grid has one level");
}

TEST(Instances, triangles_without_area_are_left_out_wherever_they_lose_it) {
  Scene scene;
  Primitive mesh;
  add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add_triangle(mesh, {0, 0, 0}, {0.3F, 0.3F, 0.3F}, {0.7F, 0.7F, 0.7F});  // none of its own
  add_mesh(scene, "mesh", std::move(mesh), lambert(0.5F));
  const auto put = [&](const glm::dmat4& m) {
    scene.nodes.emplace_back();
    scene.nodes.back().world_from_object = m;
  };
  put(glm::rotate(glm::dmat4(1), 0.3, glm::dvec3(1, 1, 0)));
  put(glm::translate(glm::dmat4(1), {1e9, 0, 0}));  // where corners fall together
  put(glm::scale(glm::dmat4(1), {1, 1, 0}));        // no way back
  const InstancedMeshes instanced = find_instanced_meshes(scene);
  EXPECT_EQ(instanced.is_instance, (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(instanced.meshes.at(0).triangles, 1U);
}

}  // namespace
}  // namespace eikon::test
