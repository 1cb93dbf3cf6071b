// SPDX-License-Identifier: Apache-2.0
// Geometry at its limits: sizes, scales, degenerate and repeated shapes, and what they must look
// like.
#include "pack/pack.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

Settings sky(std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.environment.radiance = glm::vec3(1);
  return settings;
}

TEST(Geometry, G6_a_rectangle_sees_the_whole_sky_at_every_size) {
  for (double size : {1e-5, 1.0, 1e2, 1e4, 1e7}) {
    Scene scene;
    Primitive floor;
    const auto s = static_cast<float>(size);
    // Slanted, away from the origin: no coordinate is special.
    add_quad(floor, {0.37F * s, 0.21F * s, 0.83F * s}, {s, 0.13F * s, 0.07F * s}, {0.11F * s, 0.09F * s, -s});
    add_mesh(scene, "floor", std::move(floor), lambert(0.5F));
    Settings settings = sky(24, 16);
    for (double distance : {1.0, 1e-3}) {
      const glm::dvec3 middle = glm::dvec3(0.37 + 0.555, 0.21 + 0.11, 0.83 - 0.465) * size;
      settings.camera = look_at_camera(middle + glm::dvec3(0.1, 0.5, 0.2) * size * distance, middle, {0, 0, 1}, 0.5);
      expect_constant(film_of(scene, settings), 0.5,
                      "size " + std::to_string(size) + " from " + std::to_string(distance));
    }
  }
}

TEST(Geometry, G7_a_far_sphere_has_no_rings) {
  Scene scene;
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 32, false), lambert(0.5F));
  for (double distance : {10.0, 1e3, 1e5}) {
    Settings settings = sky(32, 16);
    settings.camera =
        look_at_camera({0, 0.3 * distance, distance}, {0, 0, 0}, {0, 1, 0}, 1.2 / distance);  // inside the disc
    expect_constant(film_of(scene, settings), 0.5, "distance " + std::to_string(distance));
  }
}

TEST(Geometry, G8_a_sphere_far_from_the_origin_has_no_dark_limb) {
  Scene scene;
  Node& node = add_mesh(scene, "ball", sphere({0, 0, 0}, 1600, 32, false), lambert(0.5F));
  node.world_from_object = glm::translate(glm::dmat4(1), {8e5, 0, 0});
  Settings settings = sky(32, 16);
  settings.camera = look_at_camera({8e5, 0, 3200}, {8e5, 0, 0}, {0, 1, 0}, 0.7);
  expect_constant(film_of(scene, settings), 0.5, "at 8e5");
}

/// A room of 2 m around `center` whose walls reach half a metre past each other.
Scene room_of_crossing_walls(const glm::vec3& center) {
  Primitive box;
  for (const int axis : {0, 1, 2})
    for (const float side : {-1.0F, 1.0F}) {
      glm::vec3 origin = center - 1.5F, edge_u(0), edge_v(0);
      origin[axis] = center[axis] + side;
      edge_u[(axis + 1) % 3] = edge_v[(axis + 2) % 3] = 3;
      add_quad(box, origin, edge_u, edge_v);
    }
  Scene scene;
  add_mesh(scene, "room", std::move(box), lambert(0.9F));
  return scene;
}

/// A million paths in a room around `center`, under a bright sky outside.
double light_inside(const Scene& scene, const glm::vec3& center, std::uint32_t seed) {
  Settings settings = sky(128, 64);
  settings.seed = seed;
  settings.camera = look_at_camera(glm::dvec3(center) + glm::dvec3(0.2, 0.1, 0.3),
                                   glm::dvec3(center) + glm::dvec3(-1, -0.3, -0.8), {0, 1, 0}, 2.0);
  return mean_of(film_of(scene, settings)).mean;
}

TEST(Geometry, a_closed_box_is_dark_inside) {
  Primitive box;
  add_box(box, glm::vec3(-1), glm::vec3(1), true);
  Scene walls_that_end_where_others_begin;
  add_mesh(walls_that_end_where_others_begin, "box", std::move(box), lambert(0.9F));
  const Scene walls_that_cross = room_of_crossing_walls(glm::vec3(0));
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    EXPECT_EQ(light_inside(walls_that_end_where_others_begin, glm::vec3(0), seed), 0) << "seed " << seed;
    EXPECT_EQ(light_inside(walls_that_cross, glm::vec3(0), seed), 0) << "crossing walls, seed " << seed;
  }
}

// Far from the origin rounding moves hits by more of the room: of a thousand times as many rays one
// is put beyond a wall.
TEST(Geometry, a_room_of_crossing_walls_far_away_is_dark_inside) {
  for (const glm::vec3& center : {glm::vec3(64, -50, 40), glm::vec3(1000, 300, -700)})
    for (std::uint32_t seed = 0; seed < 4; ++seed)
      EXPECT_EQ(light_inside(room_of_crossing_walls(center), center, seed), 0) << center.x << ", seed " << seed;
}

TEST(Geometry, G15_ten_thousand_copies_of_a_triangle_look_like_one) {
  const auto copies = [](int count) {
    Scene scene;
    Primitive primitive;
    for (int i = 0; i < count; ++i) add_triangle(primitive, {-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
    add_mesh(scene, "copies", std::move(primitive), lambert(0.5F));
    return scene;
  };
  Settings settings = sky(16, 4);
  settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.6);
  const Film one = film_of(copies(1), settings), many = film_of(copies(10000), settings);
  EXPECT_TRUE(same_film(one, many));
  EXPECT_NEAR(one.mean(8, 8, 0), 0.5, 1e-5);
}

TEST(Geometry, G16_power_of_an_area_light_is_that_of_its_true_area) {
  Scene scene;
  Primitive quad;
  add_quad(quad, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add_triangle(quad, {0, 0, 0}, {0, 0, 1}, {1, 0, 1});
  Node& node = add_mesh(scene, "light", std::move(quad), lambert(0, 3));
  // A shear through parents with scales (1, 1e-3, 1e3).
  node.world_from_object = glm::rotate(glm::dmat4(1), 0.7, {1.0, 2.0, 3.0}) *
                           glm::scale(glm::dmat4(1), {1.0, 1e-3, 1e3}) *
                           glm::rotate(glm::dmat4(1), 0.4, {0.0, 0.3, 1.0});
  const glm::dmat3 m(node.world_from_object);
  const double area = glm::length(glm::cross(m * glm::dvec3(1, 0, 0), m * glm::dvec3(0, 1, 0))) +
                      0.5 * glm::length(glm::cross(m * glm::dvec3(0, 0, 1), m * glm::dvec3(1, 0, 1)));
  const Settings settings = settings_for(4, 4, 1);
  const PackedScene packed = pack_scene(scene, Features(scene, settings), settings);
  ASSERT_EQ(packed.light_summary.size(), 1U);
  // Corners are floats: 3e-5 m off where they are 1e3 m away.
  EXPECT_NEAR(packed.light_summary[0].flux / (3 * std::numbers::pi * area), 1, 1e-4);
}

TEST(Geometry, G16_a_stretched_node_lights_as_its_baked_mesh) {
  // The unit square light, from a square that is 1000 times too thin and 1000 times too long.
  Scene scene = square_light();
  for (glm::vec3& p : scene.meshes[1].primitives[0].positions_object) p = p * glm::vec3(1, 1e3F, 1e-3F);
  scene.nodes[1].world_from_object = glm::scale(glm::dmat4(1), {1.0, 1e-3, 1e3});
  Settings settings = settings_for(16, 16, 512);
  settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), kSquareLightIrradiance / std::numbers::pi, 1));
}

TEST(Geometry, G16_normals_stay_perpendicular_under_uneven_scale) {
  Scene scene;
  Primitive quad;
  add_quad(quad, {-1, -1, -1}, {2, 0, 2}, {0, 2, 0});
  const glm::vec3 n = glm::normalize(glm::cross(glm::vec3(2, 0, 2), glm::vec3(0, 2, 0)));
  quad.normals_object.assign(4, n);
  Node& node = add_mesh(scene, "quad", std::move(quad), lambert(0.5F));
  node.world_from_object = glm::scale(glm::dmat4(1), {1.0, 1e-3, 1e3});
  const glm::dmat3 m(node.world_from_object);
  const glm::dvec3 tangent = m * glm::dvec3(2, 0, 2), bitangent = m * glm::dvec3(0, 2, 0);
  const glm::dvec3 middle = m * glm::dvec3(0, 0, 0), normal = glm::normalize(glm::cross(tangent, bitangent));
  Settings settings = sky(4, 4);
  settings.aovs = {"normal"};
  settings.camera = look_at_camera(middle + normal * 1e-3, middle, bitangent, 0.5);
  const Film film = film_of(scene, settings);
  const std::uint32_t x = film.channel_index("normal.X").value();
  const glm::dvec3 seen(film.mean(2, 2, x), film.mean(2, 2, x + 1), film.mean(2, 2, x + 2));
  EXPECT_NEAR(glm::length(seen), 1, 1e-5);
  EXPECT_LT(std::abs(glm::dot(seen, glm::normalize(tangent))), 1e-5);
  EXPECT_LT(std::abs(glm::dot(seen, glm::normalize(bitangent))), 1e-5);
}

TEST(Geometry, G17_a_mirrored_light_emits_from_its_mirrored_front) {
  Scene scene = square_light();
  Node& light = scene.nodes[1];
  light.world_from_object = glm::scale(glm::dmat4(1), {1.0, -1.0, 1.0});  // now at y = -1, and faces up
  light.mirrored = true;
  Settings settings = settings_for(16, 16, 512);
  settings.camera = look_at_camera({0, -0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), kSquareLightIrradiance / std::numbers::pi, 1));
  settings.camera = look_at_camera({0, -3, 0.001}, {0, -1, 0}, {0, 1, 0}, 0.01);
  EXPECT_EQ(mean_of(film_of(scene, settings)).mean, 0) << "its back emits";
}

TEST(Geometry, G18_a_flat_node_is_a_flat_object) {
  Scene scene;
  Node& node = add_mesh(scene, "pancake", sphere({0, 0, 0}, 1, 16, false), lambert(0.5F));
  node.world_from_object =
      glm::rotate(glm::dmat4(1), 0.3, {0.2, 0.1, 1.0}) * glm::scale(glm::dmat4(1), {1.0, 0.0, 1.0});
  Settings settings = sky(24, 16);
  settings.camera = look_at_camera({0, 4, 0}, {0, 0, 0}, {0, 0, 1}, 0.3);
  expect_constant(film_of(scene, settings), 0.5, "flat");
}

TEST(Geometry, G18_smooth_normals_of_a_flat_node_are_finite) {
  Scene scene;
  Node& node = add_mesh(scene, "pancake", sphere({0, 0, 0}, 1, 16, false, true), lambert(0.5F));
  node.world_from_object = glm::scale(glm::dmat4(1), {1.0, 0.0, 1.0});
  Settings settings = sky(24, 16);
  settings.camera = look_at_camera({0, 4, 0}, {0, 0, 0}, {0, 0, 1}, 0.3);
  expect_constant(film_of(scene, settings), 0.5, "flat and smooth");
}

TEST(Geometry, G11_triangles_without_area_change_no_bit) {
  auto made = room(32, 24, 8);
  const Film expected = film_of(made.first, made.second);
  for (Mesh& mesh : made.first.meshes) {
    Primitive& primitive = mesh.primitives[0];
    for (std::uint32_t i = 0; i < 3; ++i)
      for (const std::uint32_t corner : {i, i, i + 1}) primitive.indices.push_back(corner);
    for (int i = 0; i < 3; ++i) primitive.indices.push_back(0);
  }
  const Film found = film_of(made.first, made.second);
  EXPECT_TRUE(same_film(expected, found));
}

}  // namespace
}  // namespace eikon::test
