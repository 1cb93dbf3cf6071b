// SPDX-License-Identifier: Apache-2.0
// The camera of a file that has none.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scene/view/framing.h"

namespace eikon {
namespace {

/// A scene of one mesh of loose points, three per triangle.
Scene scene_of(const std::vector<glm::vec3>& points) {
  Scene scene;
  scene.materials.resize(1);
  Primitive primitive;
  primitive.positions_object = points;
  for (std::uint32_t i = 0; i < points.size(); ++i) primitive.indices.push_back(i);
  scene.meshes.push_back({.name = "points", .primitives = {primitive}});
  scene.nodes.push_back({.name = "node"});
  return scene;
}

/// The places of all vertices in the picture; +-1 is its border.
std::vector<glm::dvec2> places(const Scene& scene, const Camera& camera, double aspect) {
  const glm::dmat4 camera_from_world = glm::inverse(camera.world_from_camera);
  const double half = std::tan(0.5 * camera.yfov_rad);
  std::vector<glm::dvec2> result;
  for (const glm::vec3& p : scene.meshes[0].primitives[0].positions_object) {
    const glm::dvec3 seen(camera_from_world * glm::dvec4(p, 1.0));
    EXPECT_LT(seen.z, 0);
    result.emplace_back(seen.x / -seen.z / half / aspect, seen.y / -seen.z / half);
  }
  return result;
}

const std::vector<glm::vec3> kBrick{{-1, 10, 3}, {4, 10, 3}, {-1, 11, 3}, {4, 11, 3},    {-1, 10, 9},   {4, 10, 9},
                                    {-1, 11, 9}, {4, 11, 9}, {1, 10, 5},  {1, 10, 6.5F}, {1, 10.5F, 7}, {2, 11, 8}};

TEST(Framing, what_is_shown_fills_the_picture_at_any_aspect) {
  const Scene scene = scene_of(kBrick);
  for (const double aspect : {0.2, 1.0, 16.0 / 9, 5.0}) {
    const Camera camera = frame_camera(scene, aspect);
    EXPECT_NEAR(camera.yfov_rad, 40 * M_PI / 180, 1e-12);
    glm::dvec2 lo(1e300), hi(-1e300);
    for (const glm::dvec2& place : places(scene, camera, aspect)) lo = glm::min(lo, place), hi = glm::max(hi, place);
    EXPECT_LE(std::max({hi.x, hi.y, -lo.x, -lo.y}), 0.92 + 1e-9) << "nothing is cut off";
    EXPECT_GE(std::max({hi.x, hi.y}), 0.92 - 1e-9) << "the margin is touched";
    EXPECT_NEAR(hi.x, -lo.x, hi.x > 0.92 - 1e-9 ? 1e-9 : 0.5) << "on both sides";
    EXPECT_NEAR(hi.y, -lo.y, hi.y > 0.92 - 1e-9 ? 1e-9 : 0.5) << "at the top and at the bottom";
  }
}

TEST(Framing, several_poses_fit_in_together) {
  const Scene first = scene_of(kBrick), second = scene_of({{20, 10, 3}, {21, 12, 3}, {20, 10, 4}});
  Framing framing(1.5);
  framing.add(first);
  framing.add(second);
  const Camera both = framing.camera();
  double largest = 0;
  for (const Scene* scene : {&first, &second})
    for (const glm::dvec2& place : places(*scene, both, 1.5))
      largest = std::max({largest, std::abs(place.x), std::abs(place.y)});
  EXPECT_NEAR(largest, 0.92, 1e-9);
  EXPECT_EQ(Framing(1).camera().world_from_camera, frame_camera(Scene(), 1).world_from_camera) << "without anything";
}

TEST(Framing, the_camera_stands_in_front_to_the_right_and_above) {
  const glm::dvec3 back(frame_camera(scene_of(kBrick), 1).world_from_camera[2]);
  EXPECT_GT(back.z, back.x);
  EXPECT_GT(back.x, 0);
  EXPECT_GT(back.y, 0);
}

TEST(Framing, what_never_shows_does_not_count) {
  Scene scene = scene_of(kBrick);
  const glm::dvec4 eye = frame_camera(scene, 1).world_from_camera[3];
  Primitive far;
  far.positions_object = {{1e3F, 0, 0}, {1e3F, 1, 0}, {1e3F, 0, 1}};
  far.indices = {0, 1, 2};
  far.material = 1;
  scene.meshes[0].primitives.push_back(far);
  scene.materials.push_back({.name = "clear", .opacity = 0, .alpha_mode = AlphaMode::blend});
  EXPECT_EQ(glm::dvec3(frame_camera(scene, 1).world_from_camera[2]), glm::normalize(glm::dvec3(0.5, 0.4, 0.9)));
  EXPECT_LT(glm::length(frame_camera(scene, 1).world_from_camera[3] - eye), 1e-9);
  scene.materials[1].opacity = 0.1F;
  EXPECT_GT(glm::length(frame_camera(scene, 1).world_from_camera[3] - eye), 100);
}

TEST(Framing, scales_exactly_with_the_scene) {
  std::vector<glm::vec3> small = kBrick;
  for (glm::vec3& p : small) p *= 0x1p-20F;
  const glm::dvec3 eye(frame_camera(scene_of(kBrick), 1.5).world_from_camera[3]);
  EXPECT_EQ(eye * 0x1p-20, glm::dvec3(frame_camera(scene_of(small), 1.5).world_from_camera[3]));
}

TEST(Framing, survives_a_point_a_flat_triangle_and_nothing) {
  for (const Scene& scene :
       {Scene{}, scene_of({glm::vec3(1), glm::vec3(1), glm::vec3(1)}), scene_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
        scene_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}) {
    const Camera camera = frame_camera(scene, 1);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) EXPECT_TRUE(std::isfinite(camera.world_from_camera[c][r]));
    if (scene.meshes.empty()) continue;
    for (const glm::dvec2& place : places(scene, camera, 1)) EXPECT_LE(glm::length(place), 1.5);
  }
}

}  // namespace
}  // namespace eikon
