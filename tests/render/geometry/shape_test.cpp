// SPDX-License-Identifier: Apache-2.0
// Pictures of shapes: nothing leaks, nothing shadows itself, and they look as the triangles do that
// come close to them.
#include <set>

#include "pack/pack.h"
#include "render/materials/glass_builder.h"
#include "render/ways_to_shade.h"
#include "scene/endless.h"

namespace eikon::test {
namespace {

/// A material and a sphere of it.
Shape& add_sphere(Scene& scene, const glm::dmat4& place, double radius, const Material& material) {
  scene.materials.push_back(material);
  Shape shape;
  shape.name = "sphere";
  shape.kind = ShapeKind::sphere;
  shape.size[0] = radius;
  shape.world_from_object = place;
  shape.material = std::uint32_t(scene.materials.size() - 1);
  return scene.shapes.emplace_back(shape);
}

glm::dmat4 at(double x, double y, double z) { return glm::translate(glm::dmat4(1), {x, y, z}); }
glm::dmat4 askew() {
  return glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2)) * glm::scale(glm::dmat4(1), {1.0, 0.2, 0.5}) *
         glm::rotate(glm::dmat4(1), 1.1, glm::dvec3(1, 0.4, 0.1));
}

TEST(Shapes, G7_a_sphere_shows_its_albedo_under_the_sky_from_near_and_far_at_every_size) {
  for (const bool stretched : {false, true}) {
    for (const double radius : {1e-5, 0.015, 1.0, 1e4, 1e7}) {
      Scene scene;
      const glm::dmat4 place = at(0.3 * radius, 0.083 * radius, 0.4 * radius) * (stretched ? askew() : glm::dmat4(1));
      add_sphere(scene, place, radius, lambert(0.5F));
      const glm::dvec3 center(place[3]);
      for (const double distance : {1.5, 10.0, 1e3, 1e5}) {
        Settings settings = settings_under_sky(24, 16);
        settings.camera = look_at_camera(center + radius * distance * glm::dvec3(0.1, 0.3, 0.95), center, {0, 1, 0},
                                         (stretched ? 0.2 : 0.9) / distance);
        expect_constant(film_of(scene, settings), 0.5,
                        "radius " + std::to_string(radius) + ", distance " + std::to_string(distance));
      }
    }
  }
}

TEST(Shapes, G8_a_sphere_far_from_the_origin_has_no_dark_limb) {
  Scene scene;
  add_sphere(scene, at(8e5, 0, 0), 1600, lambert(0.5F));
  Settings settings = settings_under_sky(32, 16);
  settings.camera = look_at_camera({8e5, 0, 3200}, {8e5, 0, 0}, {0, 1, 0}, 0.7);
  expect_constant(film_of(scene, settings), 0.5, "at 8e5");
}

/// A plane without end; its front is +Y of the place.
void add_endless_plane(Scene& scene, const glm::dmat4& place, const Material& material) {
  Shape& plane = add_sphere(scene, place, 1, material);
  plane.kind = ShapeKind::plane;
  plane.size = {kEndlessSize, kEndlessSize, 0};
}

TEST(Shapes, a_plane_without_end_is_seen_up_to_the_horizon) {
  for (const bool tilted : {false, true}) {
    const glm::dmat4 turn = tilted ? glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2)) : glm::dmat4(1);
    Scene scene;
    add_endless_plane(scene, turn, lambert(0.5F));
    const glm::dvec3 up(turn[1]), eye = glm::dvec3(turn * glm::dvec4(0.1, 1, 0.2, 1));
    // The narrowest has its lowest row 10^9 m away. Floats know the direction of what is askew less
    // well.
    for (const double fov : tilted ? std::vector<double>{1.0, 0.01} : std::vector<double>{1.0, 0.01, 1e-5, 2e-9}) {
      Settings settings = settings_under_sky(16, 16);
      settings.camera = look_at_camera(eye, eye - glm::dvec3(turn[2]), up, fov);
      const Film film = film_of(scene, settings);
      for (std::uint32_t y = 0; y < 16; ++y)
        for (std::uint32_t x = 0; x < 16; ++x)
          if (y < 6 || y > 9) {
            ASSERT_NEAR(film.mean(x, y, 0), y < 6 ? 1 : 0.5, 4e-6)
                << tilted << " " << fov << ", pixel " << x << "," << y;
          }
    }
    // From straight above, as parallel rays and from far away.
    Settings settings = settings_under_sky(8, 16);
    settings.camera = look_at_camera(eye + 1e5 * up, eye, glm::dvec3(turn[2]), 1.0);
    expect_constant(film_of(scene, settings), 0.5, "from above");
    settings.camera.projection = Projection::orthographic;
    settings.camera.ymag_m = 1e6;
    expect_constant(film_of(scene, settings), 0.5, "parallel rays");
  }
}

TEST(Shapes, a_plane_without_end_lights_what_is_above_it) {
  Scene scene;
  add_endless_plane(scene, at(0, -1, 0), lambert(0.0F, 1.0F));
  add_endless_plane(scene, at(0, 1, 0) * glm::rotate(glm::dmat4(1), 3.14159265358979, glm::dvec3(1, 0, 0)),
                    lambert(0.5F));
  Settings settings = settings_for(8, 8, 16);
  settings.camera = look_at_camera({0, 0, 0}, {0.1, 1, 0}, {0, 0, 1}, 0.9);
  expect_constant(film_of(scene, settings), 0.5, "above");
}

TEST(Shapes, a_closed_sphere_is_dark_inside) {
  for (const bool stretched : {false, true}) {
    for (const double far : {0.0, 1e3}) {
      Scene scene;
      add_sphere(scene, at(far, -far, far) * (stretched ? askew() : glm::dmat4(1)), 1, lambert(0.9F));
      Settings settings = settings_under_sky(64, 64);
      const glm::dvec3 eye(far + 0.02, -far, far + 0.03);
      settings.camera = look_at_camera(eye, eye + glm::dvec3(1, 0.2, 0.3), {0, 1, 0}, 2.0);
      const Film film = film_of(scene, settings);
      for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) ASSERT_EQ(film.mean(x, y, 0), 0) << "pixel " << x << "," << y;
    }
  }
}

TEST(Shapes, L9_a_furnace_of_a_sphere_is_constant) {
  // Le = 1/2 and albedo 1/2 from every side of the wall: 1. The front of a sphere is outside, so
  // both sides emit.
  Scene scene;
  Material wall = lambert(0.5F, 0.5F);
  wall.double_sided = true;
  add_sphere(scene, askew(), 1, wall);
  Settings settings = settings_for(16, 16, 256);
  settings.camera = look_at_camera({0.02, 0.01, 0.03}, {1, 0.2, 0.3}, {0, 1, 0}, 2.0);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 1));
}

TEST(Shapes, M12_a_glass_sphere_vanishes_in_a_constant_sky) {
  Scene scene;
  add_sphere(scene, at(0.1, 0.2, 0.3), 1, glass(1.5F, 0, true));
  Settings settings = settings_under_sky(24, 64);
  settings.camera = look_at_camera({0, 0.5, 4}, {0, 0, 0}, {0, 1, 0}, 0.6);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 1));
}

TEST(Shapes, G5_a_sphere_just_inside_another_is_met_through_it) {
  for (const double gap : {4e-5, 4e-6}) {
    Scene scene;
    Material clear = glass(1.5F, 0, true);
    clear.ior = 1;
    add_sphere(scene, glm::dmat4(1), 1 + gap, clear);
    add_sphere(scene, glm::dmat4(1), 1, lambert({0.7F, 0.1F, 0.2F}));
    Settings settings = settings_under_sky(24, 64);
    settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.3);
    const Film film = film_of(scene, settings);
    EXPECT_TRUE(agrees(mean_of(film, 0), 0.7, 2, 1e-4)) << gap;
    EXPECT_TRUE(agrees(mean_of(film, 1), 0.1, 2, 1e-3)) << gap;
  }
}

/// A room with some of every kind of shape and material beside the triangles.
std::pair<Scene, Settings> furnished(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  std::pair<Scene, Settings> made = room(width, height, spp);
  Scene& scene = made.first;
  add_sphere(scene, at(0.1, -0.75, 0.5), 0.25, lambert({0.2F, 0.6F, 0.3F}));
  add_sphere(scene, at(-0.5, -0.2, 0.4) * askew(), 0.5, lambert({0.6F, 0.6F, 0.1F}));
  add_sphere(scene, at(0.4, 0.1, 0.3), 0.2, glass(1.5F, 0, true));
  Material veil = lambert({0.9F, 0.2F, 0.9F});
  veil.alpha_mode = AlphaMode::blend;
  veil.opacity = 0.5F;
  add_sphere(scene, at(-0.1, 0.5, 0.3), 0.3, veil);
  return made;
}

TEST(Shapes, every_way_to_shade_gives_the_same_film) {
  const auto [scene, settings] = furnished(24, 16, 8);
  const std::vector<Execution> ways = ways_to_shade();
  const Film first = film_of(scene, settings, ways.front());
  for (std::size_t i = 1; i < ways.size(); ++i)
    EXPECT_TRUE(same_film(first, film_of(scene, settings, ways[i]))) << describe(ways[i]);
}

TEST(Shapes, a_scene_times_a_power_of_two_gives_the_same_film) {
  const auto original = furnished(24, 16, 8);
  const Film film = film_of(original.first, original.second);
  for (const double factor : {0x1p-12, 0x1p17}) {
    const auto scaled = times(original, factor);
    EXPECT_TRUE(same_film(film, film_of(scaled.first, scaled.second))) << factor;
  }
}

TEST(Shapes, a_sphere_looks_as_its_triangles_do) {
  const auto make = [](bool analytic, const glm::dmat4& place) {
    Scene scene;
    Primitive floor;
    add_quad(floor, {-3, -1, 3}, {6, 0, 0}, {0, 0, -6});
    add_mesh(scene, "floor", std::move(floor), lambert({0.7F, 0.3F, 0.2F}));
    if (analytic)
      add_sphere(scene, place, 1, lambert({0.3F, 0.8F, 0.5F}));
    else
      add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 128, false, true), lambert({0.3F, 0.8F, 0.5F})).world_from_object =
          place;
    return scene;
  };
  for (const glm::dmat4& place : {at(0.2, 0.1, 0), at(0.1, 0.1, 0.2) * askew()}) {
    Settings settings = settings_under_sky(32, 256);
    settings.camera = look_at_camera({0.5, 1, 4}, {0, -0.2, 0}, {0, 1, 0}, 0.8);
    const Film smooth = film_of(make(true, place), settings);
    settings.seed = 1;
    const Film faceted = film_of(make(false, place), settings);
    for (const std::uint32_t channel : {0U, 1U, 2U})
      for (std::uint32_t y = 0; y < 32; y += 8)
        for (std::uint32_t x = 0; x < 32; x += 8) {
          const Crop window{x, y, x + 8, y + 8};
          const MeanAndError a = mean_of(smooth, channel, window), b = mean_of(faceted, channel, window);
          // The facets lie inside the sphere by 3e-4 of its radius at most, which moves its
          // silhouette by 0.01 pixels.
          EXPECT_TRUE(agrees({a.mean, std::hypot(a.sigma, b.sigma)}, b.mean, 96, 2e-3)) << x << "," << y;
        }
  }
}

TEST(Shapes, a_scene_without_shapes_has_nothing_of_them_in_its_programs) {
  const auto [scene, settings] = room(8, 8, 1);
  const Features features(scene, settings);
  EXPECT_FALSE(features.has(Feature::shape));
  EXPECT_FALSE(features.has(Feature::sphere));
  EXPECT_TRUE(pack_scene(scene, features, settings).shapes.empty());
}

TEST(Shapes, the_id_layer_tells_shapes_from_nodes) {
  Scene scene;
  add_sphere(scene, at(-1, 0, 0), 0.5, lambert(0.5F));
  add_sphere(scene, at(1, 0, 0), 0.5, lambert(0.5F));
  Settings settings = settings_under_sky(16, 1);
  settings.aovs = {"id"};
  settings.camera = look_at_camera({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.7);
  const Film film = film_of(scene, settings);
  std::set<double> ids;
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) ids.insert(std::round(film.mean(x, y, 3)));
  EXPECT_EQ(ids, (std::set<double>{0, 1, 2}));
}

}  // namespace
}  // namespace eikon::test
