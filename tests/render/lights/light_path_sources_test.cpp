// SPDX-License-Identifier: Apache-2.0
// Light paths that start from emissive shapes.
#include "render/lights/light_path_scenes.h"
#include "scene/shape_area.h"

namespace eikon::test {
namespace {

/// The glass ball and the mirror in a room that a shape lights. All kinds are there, of which the
/// others are black and out of sight, so that all such scenes share programs.
std::pair<Scene, Settings> room_lit_by(ShapeKind kind, bool double_sided, std::uint64_t spp) {
  auto [scene, settings] = room_of_glass(24, spp);
  scene.materials[1].emission = glm::vec3(0);
  const glm::dmat4 askew = glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2)) *
                           glm::scale(glm::dmat4(1), {1.0, 0.6, 0.8}) *
                           glm::rotate(glm::dmat4(1), 1.1, glm::dvec3(1, 0.4, 0.1));
  for (const ShapeKindInfo& other : shape_kinds()) {
    const bool lit = other.kind == kind;
    Material material = lambert(0.3F, lit ? 5 : 0);
    material.double_sided = lit && double_sided;
    scene.materials.push_back(material);
    Shape shape;
    shape.name = other.name;
    shape.kind = other.kind;
    shape.size = {0.5, 0.35, 0.3};
    shape.world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(0, lit ? 0.7 : 7, 0.2)) * askew;
    shape.material = std::uint32_t(scene.materials.size() - 1);
    scene.shapes.push_back(shape);
  }
  return {std::move(scene), settings};
}

TEST(LightPathSources, shapes_bring_the_mean_that_paths_from_the_camera_find) {
  const int comparisons = int(shape_kinds().size()) * 4 * 3;
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::implicit) continue;  // which is no sampled light
    const auto [scene, settings] = room_lit_by(kind.kind, kind.kind == ShapeKind::plane, 1024);
    EXPECT_FALSE(expect_the_same_mean(kind.name, scene, settings, 2048, comparisons).light_paths().empty())
        << kind.name;
  }
}

TEST(LightPathSources, shapes_have_a_fraction_of_the_error) {
  auto [scene, settings] = room_lit_by(ShapeKind::sphere, false, 64);
  scene.shapes.front().size = {0.05};
  settings.max_depth = 8;
  const auto [without, with] = errors_of(scene, settings);
  EXPECT_LT(with, 0.35 * without) << without << " without";
}

// Light paths begin outside of all solids. What shines within one that absorbs has none.
TEST(LightPathSources, lamps_that_shine_within_amber_bring_the_mean_that_paths_from_the_camera_find) {
  for (const bool is_surface : {true, false}) {
    Scene scene;
    Primitive floor, lamp;
    add_quad(floor, {-3, -0.5F, 3}, {6, 0, 0}, {0, 0, -6});
    add_mesh(scene, "floor", std::move(floor), lambert(0.6F));
    Material solid = amber(0.1F, 1.5F);
    solid.emission = glm::vec3(is_surface ? 1 : 0);
    solid.double_sided = is_surface;
    add_mesh(scene, "ball", sphere({0, 0, 0}, 0.5F, 12, false, true), solid);
    // Its middle is outside of the ball.
    Material shining = lambert(0, is_surface ? 0 : 5);
    shining.double_sided = true;
    add_quad(lamp, {0.3F, 0, -0.1F}, {0.6F, 0, 0}, {0, 0, 0.2F});
    add_mesh(scene, "lamp", std::move(lamp), shining);
    Settings settings = settings_for(16, 16, 4096);
    settings.camera = look_at_camera({0, 1.5, 2.5}, {0.2, -0.2, 0}, {0, 1, 0}, 0.7);
    settings.max_depth = 8;
    const MeanAndError expected = mean_of(film_of(scene, settings));
    settings.seed = 5;
    const MeanAndError found = mean_of(film_of(scene, with_light_paths(settings, 1)));
    EXPECT_TRUE(agree(found, expected, 2)) << is_surface << ": " << found.mean << " and " << expected.mean;
  }
}

}  // namespace
}  // namespace eikon::test
