// SPDX-License-Identifier: Apache-2.0
// The poses that a scene takes while the shutter is open.
#include "gltf/animation/shutter_poses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "support/messages.h"
#include "support/paths.h"

namespace eikon::test {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Scene triangle_at(const glm::dmat4& place) {
  Scene scene;
  Primitive primitive;
  primitive.positions_object = std::vector<glm::vec3>{{1, 0, 0}, {-0.5F, 0.8F, 0}, {-0.5F, -0.8F, 0}};
  primitive.indices = {0, 1, 2};
  scene.meshes.push_back({"triangle", {primitive}});
  scene.materials.emplace_back();
  scene.nodes.push_back({.name = "node", .world_from_object = place, .mesh = 0});
  scene.animations.push_back({.name = "motion", .begin_s = 0, .end_s = 1, .channel_count = 1, .in_force = true});
  return scene;
}

/// As a scene whose shutter is open from 0 to 1 s.
Scene exposed(const PoseLoader& scene_at, std::uint32_t steps = 0) {
  Scene scene = scene_at(0);
  add_shutter_poses(scene, {.open_s = 0, .close_s = 1, .steps = steps}, scene_at);
  return scene;
}

Scene turning(double turns, double t) {
  return triangle_at(glm::rotate(glm::dmat4(1), turns * kTurn * t, glm::dvec3(0, 0, 1)));
}

TEST(ShutterPoses, what_goes_straight_has_one_step_and_what_turns_has_more_the_more_it_turns) {
  const auto straight = [](double t) { return triangle_at(glm::translate(glm::dmat4(1), glm::dvec3(3 * t, t, 0))); };
  EXPECT_EQ(exposed(straight).shutter.steps, 1U);
  std::uint32_t before = 1;
  for (const double turns : {0.01, 0.1, 0.5, 1.0}) {
    const Scene scene = exposed([&](double t) { return turning(turns, t); });
    EXPECT_GE(scene.shutter.steps, before) << turns;
    before = scene.shutter.steps;
    ASSERT_EQ(scene.poses.size(), scene.shutter.steps + 1);
    EXPECT_TRUE(scene.moves_surfaces && scene.in_motion && scene.nodes[0].moves && !scene.moves_lights);
    EXPECT_TRUE(scene.warnings.empty());
    // Nowhere is a corner farther from its circle than a thousandth of the triangle.
    for (std::size_t k = 0; k + 1 < scene.poses.size(); ++k)
      for (const double share : {0.25, 0.5, 0.75}) {
        const glm::dvec3 a(scene.poses[k]->nodes[0].world_from_object[0]),
            b(scene.poses[k + 1]->nodes[0].world_from_object[0]);
        const double angle = turns * kTurn * (double(k) + share) / scene.shutter.steps;
        EXPECT_LT(glm::length(glm::mix(a, b, share) - glm::dvec3(std::cos(angle), std::sin(angle), 0)), 3e-3) << turns;
      }
  }
  EXPECT_GE(before, 32U);
}

TEST(ShutterPoses, whole_turns_within_a_step_are_not_taken_for_rest) {
  for (const double turns : {1.0, 2.0, 4.0})
    EXPECT_GE(exposed([&](double t) { return turning(turns, t); }).shutter.steps, 32U);
}

TEST(ShutterPoses, too_fast_a_turn_is_followed_as_well_as_can_be_and_said) {
  const Scene scene = exposed([](double t) { return turning(9, t); });
  EXPECT_EQ(scene.shutter.steps, kMaxShutterSteps);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(contains(scene.warnings[0], "--motion-steps auto: 64 steps"));
}

TEST(ShutterPoses, a_number_of_steps_that_is_asked_for_is_kept) {
  const Scene scene = exposed([](double t) { return turning(0.5, t); }, 5);
  EXPECT_EQ(scene.shutter.steps, 5U);
  EXPECT_EQ(scene.poses.size(), 6U);
  EXPECT_EQ(scene.poses[5]->nodes[0].world_from_object, turning(0.5, 1).nodes[0].world_from_object);
}

TEST(ShutterPoses, a_scene_that_stands_still_or_has_no_animation_has_no_poses) {
  const Scene still = exposed([](double) { return triangle_at(glm::dmat4(1)); });
  EXPECT_TRUE(still.poses.empty() && !still.shutter.is_open() && !still.in_motion);
  const auto unasked = [](double t) {
    Scene scene = turning(0.5, t);
    scene.animations.clear();
    return scene;
  };
  EXPECT_TRUE(exposed(unasked).poses.empty());
  Scene shut = turning(0.5, 0);
  add_shutter_poses(shut, {}, [](double t) { return turning(0.5, t); });
  EXPECT_TRUE(shut.poses.empty());
}

TEST(ShutterPoses, poses_of_other_triangles_are_not_blurred_and_that_is_said) {
  const auto vanishes = [](double t) {
    Scene scene = turning(0.5, t);
    if (t > 0.7) scene.nodes.clear();
    return scene;
  };
  const Scene scene = exposed(vanishes);
  EXPECT_TRUE(scene.poses.empty());
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(contains(scene.warnings[0], "nothing is blurred, as the number of meshes that it shows changes"));
}

TEST(ShutterPoses, shapes_that_move_stand_still_and_that_is_said) {
  const Scene scene = exposed([](double t) {
    Scene at = triangle_at(glm::dmat4(1));
    for (const char* name : {"ball", "egg"}) {
      Shape shape;
      shape.name = name;
      shape.world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(t, 0, 0));
      at.shapes.push_back(shape);
    }
    return at;
  });
  EXPECT_TRUE(scene.poses.empty());
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(contains(scene.warnings[0], "shape 'ball' and 1 more: not blurred"));
}

TEST(ShutterPoses, a_node_that_turns_inside_out_keeps_the_order_of_its_corners) {
  const auto mirrors = [](double t) {
    Scene scene = triangle_at(glm::scale(glm::dmat4(1), glm::dvec3(1 - 2 * t, 1, 1)));
    scene.nodes[0].mirrored = t > 0.5;
    return scene;
  };
  const Scene scene = exposed(mirrors);
  ASSERT_FALSE(scene.poses.empty());
  for (const auto& pose : scene.poses) EXPECT_FALSE(pose->nodes[0].mirrored);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(contains(scene.warnings[0], "node 'node' turns inside out while the shutter is open")) << scene.warnings[0];
  const auto mirrors_a_sheet = [&](double t) {
    Scene sheet = mirrors(t);
    sheet.materials[0].double_sided = true;
    return sheet;
  };
  EXPECT_TRUE(exposed(mirrors_a_sheet).warnings.empty()) << "nobody sees which side is the front";
}

TEST(ShutterPoses, a_skin_that_turns_inside_out_keeps_its_normals_on_the_side_of_its_corners) {
  // As the reader makes it: corners change places where joints mirror, and normals face the front.
  const auto mirrors = [](double t) {
    Scene scene = triangle_at(glm::dmat4(1));
    Primitive& primitive = scene.meshes[0].primitives[0];
    std::vector<glm::vec3> positions;
    for (const glm::vec3& p : primitive.positions_object) positions.push_back({float(1 - 2 * t) * p.x, p.y, p.z});
    primitive.positions_object = positions;
    primitive.normals_object = std::vector<glm::vec3>(3, {0, 0, 1});
    if (t > 0.5) primitive.indices = {0, 2, 1};
    return scene;
  };
  const Scene scene = exposed(mirrors);
  ASSERT_FALSE(scene.poses.empty());
  for (const auto& pose : scene.poses) {
    const Primitive& primitive = pose->meshes[0].primitives[0];
    EXPECT_EQ(primitive.indices, scene.meshes[0].primitives[0].indices);
    const auto& p = primitive.positions_object;
    const glm::vec3 geometric = glm::cross(p[1] - p[0], p[2] - p[0]);
    for (const glm::vec3& n : primitive.normals_object) EXPECT_GE(glm::dot(n, geometric), 0);
  }
}

TEST(ShutterPoses, normals_are_followed_in_the_world) {
  // Squashing moves each corner straight, but not its normal, which turns from the flat side.
  const auto squashed = [](double t) {
    Scene scene = triangle_at(glm::scale(glm::dmat4(1), glm::dvec3(1, 1, 0.1 + 0.9 * t)));
    scene.meshes[0].primitives[0].normals_object = std::vector<glm::vec3>(3, glm::normalize(glm::vec3(1, 0, 1)));
    return scene;
  };
  const Scene scene = exposed(squashed);
  EXPECT_GE(scene.shutter.steps, 4U);
  for (std::size_t k = 0; k + 1 < scene.poses.size(); ++k) {
    const auto normal_at = [](double t) { return glm::normalize(glm::dvec3(0.1 + 0.9 * t, 0, 1)); };
    const double step = 1.0 / scene.shutter.steps, t = (double(k) + 0.5) * step;
    const glm::dvec3 mixed = glm::normalize(normal_at(t - 0.5 * step) + normal_at(t + 0.5 * step));
    EXPECT_LT(glm::distance(mixed, normal_at(t)), 1e-2) << k;
  }
}

TEST(ShutterPoses, cameras_and_lamps_are_followed_as_well) {
  const auto both = [](double t) {
    Scene scene = triangle_at(glm::dmat4(1));
    Camera camera;
    camera.world_from_camera = glm::rotate(glm::dmat4(1), 0.3 * t, glm::dvec3(0, 1, 0));
    scene.cameras = {camera};
    return scene;
  };
  const Scene panned = exposed(both);
  EXPECT_FALSE(panned.poses.empty());
  EXPECT_FALSE(panned.moves_surfaces || panned.moves_lights || panned.in_motion);
  EXPECT_GE(panned.shutter.steps, 4U);  // .3 rad have a sagitta of .011, and the rest is a square law
  const auto lamp = [](double t) {
    Scene scene = triangle_at(glm::dmat4(1));
    PunctualLight light;
    light.position = {std::cos(t), std::sin(t), 0};
    scene.lights = {light};
    return scene;
  };
  const Scene swung = exposed(lamp);
  EXPECT_TRUE(swung.moves_lights && !swung.moves_surfaces);
  EXPECT_GT(swung.shutter.steps, 1U);
}

TEST(ShutterPoses, a_zoom_to_and_fro_is_followed_and_so_is_a_focus) {
  const auto camera_with = [](const auto& change) {
    return [change](double t) {
      Scene scene = triangle_at(glm::dmat4(1));
      Camera camera;
      camera.lens = Lens{.radius_m = 0.1, .focus_distance_m = 2};
      change(camera, 1 - std::abs(2 * t - 1));
      scene.cameras = {camera};
      return scene;
    };
  };
  const auto zooms = [](Camera& camera, double share) { camera.yfov_rad = 0.7 - 0.5 * share; };
  const auto grows = [](Camera& camera, double share) {
    camera.projection = Projection::orthographic;
    camera.ymag_m = 1 + share;
  };
  const auto focuses = [](Camera& camera, double share) { camera.lens->focus_distance_m = 2 + 3 * share; };
  const auto opens = [](Camera& camera, double share) { camera.lens->radius_m = 0.1 + 0.1 * share; };
  EXPECT_GE(exposed(camera_with(zooms)).shutter.steps, 8U);
  EXPECT_GE(exposed(camera_with(grows)).shutter.steps, 2U);
  EXPECT_GE(exposed(camera_with(focuses)).shutter.steps, 8U);
  EXPECT_GE(exposed(camera_with(opens)).shutter.steps, 2U);
  EXPECT_TRUE(exposed(camera_with([](Camera&, double) {})).poses.empty());
}

TEST(ShutterPoses, a_part_of_a_mesh_that_moves_to_and_fro_is_seen_and_so_are_normals) {
  const auto bends = [](double t) {
    Scene scene = triangle_at(glm::dmat4(1));
    std::vector<glm::vec3> positions(3000, glm::vec3(0, 1, 0));
    positions[1] = {1, 0, 0};
    positions[1999].x += float(1 - std::abs(2 * t - 1));
    scene.meshes[0].primitives[0].positions_object = positions;
    return scene;
  };
  EXPECT_TRUE(exposed(bends).moves_surfaces);
  const auto turns = [](double t) {
    Scene scene = triangle_at(glm::dmat4(1));
    const double angle = 1 - std::abs(2 * t - 1);
    scene.meshes[0].primitives[0].normals_object =
        std::vector<glm::vec3>(3, glm::vec3(std::sin(angle), 0, std::cos(angle)));
    return scene;
  };
  EXPECT_TRUE(exposed(turns).moves_surfaces);
}

TEST(ShutterPoses, shapes_that_move_until_the_next_frame_are_named) {
  Scene scene = triangle_at(glm::dmat4(1));
  Shape shape;
  shape.name = "ball";
  scene.shapes = {shape};
  Scene next = scene;
  next.shapes[0].world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(1, 0, 0));
  add_next_pose(scene, next);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(contains(scene.warnings[0], "layer motion: shape 'ball': only the way of the camera is in it"));
}

TEST(ShutterPoses, materials_stay_at_the_time_of_the_frame_while_things_move) {
  SceneChoice choice;
  choice.animation.time_s = 0.5;
  choice.animation.shutter = {.open_s = 0.25, .close_s = 0.75, .steps = 2};
  const Scene scene = load_scene(std::string(EIKON_SOURCE_DIR) + "/scenes/spinning_wheel.gltf", choice);
  ASSERT_EQ(scene.poses.size(), 3U);
  for (const auto& pose : scene.poses)
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      EXPECT_EQ(pose->materials[m].emission, scene.materials[m].emission) << m;
  std::size_t moving = 0;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n)
    moving += scene.poses[0]->nodes[n].world_from_object != scene.poses[2]->nodes[n].world_from_object ? 1 : 0;
  EXPECT_GT(moving, 0U);
}

}  // namespace
}  // namespace eikon::test
