// SPDX-License-Identifier: Apache-2.0
// Whether a scene's own lights light what its camera sees, against closed forms.
#include "pack/lights/arriving_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pack/geometry/seen_points.h"

namespace eikon {
namespace {

constexpr std::uint32_t kGrey = 0, kLamp = 1;

/// Two triangles in the plane y = height, from -half to half in x and z; the front is +Y.
Primitive square(float half, float height, std::uint32_t material) {
  Primitive primitive;
  primitive.positions_object = {
      {-half, height, half}, {half, height, half}, {half, height, -half}, {-half, height, -half}};
  primitive.indices = {0, 1, 2, 0, 2, 3};
  primitive.material = material;
  return primitive;
}

Node node_of(std::uint32_t mesh, const glm::dmat4& world_from_object = glm::dmat4(1)) {
  return {.name = "node",
          .world_from_object = world_from_object,
          .mesh = mesh,
          .mirrored = glm::determinant(glm::dmat3(world_from_object)) < 0};
}

/// Turns +Y down.
glm::dmat4 upside_down(double height) {
  glm::dmat4 m(1);
  m[1] = {0, -1, 0, 0}, m[2] = {0, 0, -1, 0}, m[3] = {0.5, height, 0, 1};
  return m;
}

/// A floor of 2 m by 2 m that a camera sees from above.
Scene floor_scene() {
  Scene scene;
  scene.materials.resize(2);
  scene.materials[kLamp].emission = glm::vec3(10);
  scene.meshes.push_back({.name = "floor", .primitives = {square(1, 0, kGrey)}});
  scene.meshes.push_back({.name = "lamp", .primitives = {square(0.05F, 0, kLamp)}});
  scene.nodes.push_back(node_of(0));
  return scene;
}

/// A square picture.
Settings seen_by(const Camera& camera) {
  Settings settings;
  settings.width = settings.height = 100;
  settings.camera = camera;
  return settings;
}

const Settings kAbove = seen_by(look_at_camera({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, 0.02));  // of the middle of the floor

TEST(ArrivingLight, of_a_small_lamp_is_that_of_its_closed_form) {
  Scene scene = floor_scene();
  scene.nodes.push_back(node_of(1, upside_down(1.5)));
  // E = L A cos^2 / d^2 in the middle of the floor, where both cosines are 1.5 / d, as the lamp is
  // small.
  const double d2 = 0.5 * 0.5 + 1.5 * 1.5;
  EXPECT_NEAR(arriving_light(scene, kAbove), 10 * 0.01 * (1.5 * 1.5 / d2) / d2 / M_PI, 1e-4);
}

TEST(ArrivingLight, a_lamp_that_faces_away_gives_none_unless_it_has_two_sides) {
  Scene scene = floor_scene();
  glm::dmat4 up(1);
  up[3] = {0.5, 1.5, 0, 1};
  scene.nodes.push_back(node_of(1, up));
  EXPECT_EQ(arriving_light(scene, kAbove), 0);
  scene.materials[kLamp].double_sided = true;
  EXPECT_GT(arriving_light(scene, kAbove), 0);
  scene.materials[kLamp].double_sided = false;
  glm::dmat4 mirror = upside_down(1.5);
  mirror[0] = {-1, 0, 0, 0};  // front stays front
  scene.nodes.back() = node_of(1, mirror);
  EXPECT_GT(arriving_light(scene, kAbove), 0);
}

TEST(ArrivingLight, textures_of_lamps_count) {
  Scene scene = floor_scene();
  scene.nodes.push_back(node_of(1, upside_down(1.5)));
  const double even = arriving_light(scene, kAbove);
  scene.images.push_back({.name = "black", .width = 2, .height = 1, .rgba8 = {0xFF000000U, 0xFF000000U}});
  scene.materials[kLamp].emissive_texture = Texture{.image = 0, .filter = TextureFilter::nearest};
  scene.meshes[1].primitives[0].uv[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  EXPECT_EQ(arriving_light(scene, kAbove), 0);
  scene.images[0].rgba8[1] = 0xFFFFFFFFU;
  EXPECT_NEAR(arriving_light(scene, kAbove), 0.5 * even, 0.05 * even) << "half of the lamp is lit";
}

TEST(ArrivingLight, of_punctual_lights_is_that_of_their_closed_forms) {
  Scene scene = floor_scene();
  scene.lights.push_back({.name = "light", .kind = LightKind::point, .intensity = glm::vec3(2), .position = {0, 2, 0}});
  EXPECT_NEAR(arriving_light(scene, kAbove), 2 / 4.0 / M_PI, 1e-4);
  scene.lights[0].range_m = 1;
  EXPECT_EQ(arriving_light(scene, kAbove), 0);
  scene.lights[0] = {
      .name = "light", .kind = LightKind::directional, .intensity = glm::vec3(1.5F), .direction = {0, -1, 0}};
  EXPECT_NEAR(arriving_light(scene, kAbove), 1.5 / M_PI, 1e-6);
  scene.lights[0] = {.name = "light",
                     .kind = LightKind::spot,
                     .intensity = glm::vec3(2),
                     .position = {0, 2, 0},
                     .direction = {0, -1, 0}};
  scene.lights[0].outer_cone_rad = 0.5;
  EXPECT_NEAR(arriving_light(scene, kAbove), 2 / 4.0 / M_PI, 1e-4);
  scene.lights[0].direction = {1, 0, 0};
  EXPECT_EQ(arriving_light(scene, kAbove), 0);
}

TEST(ArrivingLight, bright_points_count_as_one) {
  Scene scene = floor_scene();
  scene.lights.push_back(
      {.name = "light", .kind = LightKind::point, .intensity = glm::vec3(1e6F), .position = {0, 2, 0}});
  EXPECT_EQ(arriving_light(scene, kAbove), 1);
}

TEST(ArrivingLight, is_infinite_where_all_that_is_seen_shines_itself) {
  Scene scene = floor_scene();
  scene.materials[kGrey].emission = glm::vec3(0.1F);
  EXPECT_TRUE(std::isinf(arriving_light(scene, kAbove)));
  scene.materials[kGrey].unlit = true;
  EXPECT_TRUE(std::isinf(arriving_light(scene, kAbove)));
}

TEST(SeenPoints, are_the_nearest_surfaces_that_are_not_clear) {
  Scene scene = floor_scene();
  scene.materials.push_back({.name = "veil", .opacity = 0.2F, .alpha_mode = AlphaMode::blend});
  scene.meshes.push_back({.name = "veil", .primitives = {square(1, 1, 2)}});
  scene.meshes.push_back({.name = "deck", .primitives = {square(1, 0.5F, kGrey)}});
  scene.nodes.push_back(node_of(2));
  scene.nodes.push_back(node_of(3));
  const std::vector<SeenPoint> points = seen_points(scene, kAbove);
  ASSERT_EQ(points.size(), 1024U);
  for (const SeenPoint& point : points) {
    ASSERT_NEAR(point.position.y, 0.5, 1e-12);
    ASSERT_EQ(point.normal, glm::dvec3(0, 1, 0));
  }
}

TEST(SeenPoints, lie_behind_backs_that_the_camera_does_not_see) {
  Scene scene = floor_scene();
  scene.meshes.push_back({.name = "ceiling", .primitives = {square(1, 0, kGrey)}});
  scene.nodes.push_back(node_of(2, upside_down(1)));
  Settings settings = kAbove;
  EXPECT_NEAR(seen_points(scene, settings).front().position.y, 1, 1e-12);
  settings.culling = Culling::camera;
  EXPECT_NEAR(seen_points(scene, settings).front().position.y, 0, 1e-12);
  scene.materials[kGrey].double_sided = true;
  EXPECT_NEAR(seen_points(scene, settings).front().position.y, 1, 1e-12);
}

TEST(SeenPoints, of_every_projection_lie_where_its_rays_meet_the_scene) {
  const Scene scene = floor_scene();
  Camera camera = look_at_camera({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 0.5 * M_PI);
  EXPECT_EQ(seen_points(scene, seen_by(camera)).size(), 1024U) << "the floor fills the picture";
  camera.yfov_rad = 2 * std::atan(2.0);
  EXPECT_EQ(seen_points(scene, seen_by(camera)).size(), 256U) << "a quarter of it";
  camera.projection = Projection::orthographic;
  camera.ymag_m = 2;
  EXPECT_EQ(seen_points(scene, seen_by(camera)).size(), 256U);
  camera.projection = Projection::panorama;
  const std::size_t face = seen_points(scene, seen_by(camera)).size();
  EXPECT_EQ(face, 169U) << "one face of a cube of 13 x 13 pixels";
  camera.world_from_camera[3].y = 0.01;
  EXPECT_GT(seen_points(scene, seen_by(camera)).size(), face) << "and the lower parts of its neighbours";
}

}  // namespace
}  // namespace eikon
