// SPDX-License-Identifier: Apache-2.0
// Pictures lit by point, spot and directional lights, whose answers are known.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

PunctualLight point_light(glm::dvec3 position, float intensity) {
  PunctualLight light;
  light.name = "bulb";
  light.position = position;
  light.intensity = glm::vec3(intensity);
  return light;
}

PunctualLight directional_light(glm::dvec3 direction, float irradiance) {
  PunctualLight light;
  light.name = "sun";
  light.kind = LightKind::directional;
  light.direction = glm::normalize(direction);
  light.intensity = glm::vec3(irradiance);
  return light;
}

/// Floor y = 0 of side 2, seen from above at the origin.
std::pair<Scene, Settings> floor_from_above(float albedo, std::uint64_t spp) {
  Primitive floor;
  add_quad(floor, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  Scene scene;
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
  Settings settings = settings_for(8, 8, spp);
  settings.camera = look_at_camera({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}, 0.001);
  return {std::move(scene), settings};
}

TEST(LightPunctual, L8_point_light_in_a_closed_sphere_that_reflects_half) {
  for (const bool four : {false, true}) {
    Scene scene;
    add_mesh(scene, "sphere", sphere({0, 0, 0}, 1, 64, true), lambert(0.5F));
    for (int i = 0; i < (four ? 4 : 1); ++i)
      scene.lights.push_back(point_light({0, 0, 0}, float(kPi) / (four ? 4 : 1)));
    Settings settings = settings_for(24, 24, 64);
    settings.camera = look_at_camera({0, 0, 0.5}, {0.2, 0.1, -1}, {0, 1, 0}, 1.2);
    // A polyhedron of 16128 faces is a sphere to (pi / 64)^2 / 2 = 1.2e-3.
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1.0, 2, 1.5e-3)) << four;
  }
}

TEST(LightPunctual, each_kind_lights_a_floor_as_its_formula_says) {
  struct Case {
    PunctualLight light;
    double irradiance;
  };
  std::vector<Case> cases;
  cases.push_back({point_light({0.3, 2, 0.4}, 5), 5 * 2 / std::pow(4.25, 1.5)});
  PunctualLight ranged = point_light({0, 2, 0}, 5);
  ranged.range_m = 4;
  cases.push_back({ranged, 5.0 / 4 * 15 / 16});
  PunctualLight spot = point_light({0, 2, 0}, 5);
  spot.kind = LightKind::spot;
  spot.direction = {std::sin(kPi / 8), -std::cos(kPi / 8), 0};  // the floor's middle is half way out of its cone
  spot.outer_cone_rad = kPi / 4;
  cases.push_back({spot, 5.0 / 4 * 0.547761});
  cases.push_back({directional_light({1, -2, 0.5}, 3), 3 * 2 / std::sqrt(5.25)});
  cases.push_back({directional_light({0, -1, 0}, 1e5F), 1e5});  // L19: a sun of 100 klx
  cases.push_back({directional_light({0, 1, 0}, 1), 0});
  cases.push_back({point_light({0, -2, 0}, 5), 0});
  for (std::size_t i = 0; i < cases.size(); ++i)
    for (LightSampling sampling : {LightSampling::mis, LightSampling::light}) {
      auto [scene, settings] = floor_from_above(0.5F, 4);
      scene.lights = {cases[i].light};
      settings.light_sampling = sampling;
      const Film film = film_of(scene, settings);
      for (std::uint32_t k = 0; k < 64; ++k)
        ASSERT_NEAR(film.mean(k % 8, k / 8, 0), 0.5 / kPi * cases[i].irradiance, 5e-4 * cases[i].irradiance + 1e-12)
            << i << ", pixel " << k;
    }
}

TEST(LightPunctual, many_lights_of_all_kinds_give_the_sum_of_each) {
  Scene scene = square_light();
  PunctualLight spot = point_light({0.1, 0.5, 0}, 0.1F);
  spot.kind = LightKind::spot;
  spot.direction = {0, -1, 0};
  spot.inner_cone_rad = 0.5;
  spot.outer_cone_rad = 0.6;
  scene.lights = {point_light({0.2, 0.3, 0.1}, 0.02F), spot, directional_light({1, -1, 0}, 0.3F),
                  point_light({0, 0.9, 0}, 0)};
  Settings settings = settings_for(16, 16, 1024);
  settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.001);
  const double expected = kSquareLightIrradiance + 0.02 * 0.3 / std::pow(0.14, 1.5) + 0.1 * 0.5 / std::pow(0.26, 1.5);
  // The directional light is kept off by the lamp above: it comes from (-1, 1, 0) and passes beside
  // it at x = -1.
  const double sun = 0.3 / std::sqrt(2.0);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), (expected + sun) / kPi, 1, 1e-4));
}

TEST(LightPunctual, L21_light_through_a_pinhole_arrives_and_none_leaks_into_a_closed_box) {
  // A screen at height 1 with a hole of side 0.01, 1e-4 sr from the origin; a lamp at height 2
  // covers all that it shows.
  const float h = 0.005F;
  Scene scene;
  Primitive floor, screen, lamp;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_quad(screen, {-5, 1, -5}, {10, 0, 0}, {0, 0, 5 - h});
  add_quad(screen, {-5, 1, h}, {10, 0, 0}, {0, 0, 5 - h});
  add_quad(screen, {-5, 1, -h}, {5 - h, 0, 0}, {0, 0, 2 * h});
  add_quad(screen, {h, 1, -h}, {5 - h, 0, 0}, {0, 0, 2 * h});
  add_quad(lamp, {-0.02F, 2, -0.02F}, {0.04F, 0, 0}, {0, 0, 0.04F});
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  add_mesh(scene, "screen", std::move(screen), lambert(0));
  Scene by_point = scene;
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 100));
  Settings settings = settings_for(8, 8, 4096);
  settings.camera = look_at_camera({0, 0.9, 0}, {0, 0, 0}, {0, 0, -1}, 0.0001);
  // A square of half side a at height 1: E / L = 4 (a / s) atan(a / s), s = sqrt(1 + a^2).
  const double a = double(h), s = std::sqrt(1 + a * a);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 100 * 4 * (a / s) * std::atan(a / s) / kPi, 2, 1e-4));
  by_point.lights = {point_light({0, 2, 0}, 1)};
  EXPECT_TRUE(agrees(mean_of(film_of(by_point, settings)), 0.25 / kPi, 2, 1e-4));

  // Walls of no thickness, each its own mesh, that meet at edges and corners alone; lights of every
  // kind outside.
  Scene box;
  const glm::vec3 x = glm::normalize(glm::vec3(1, 0.3F, 0.1F)), z = glm::normalize(glm::cross(x, {-0.3F, 1, 0.2F})),
                  y = glm::cross(z, x);
  const auto corner = [&](int i) { return (i & 1 ? x : -x) + (i & 2 ? y : -y) + (i & 4 ? z : -z); };
  const int walls[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& w : walls) {
    Primitive wall;
    add_triangle(wall, corner(w[0]), corner(w[1]), corner(w[2]));
    add_triangle(wall, corner(w[0]), corner(w[2]), corner(w[3]));
    add_mesh(box, "wall", std::move(wall), lambert(0.9F));
  }
  Settings inside = settings_for(48, 48, 32);
  inside.max_depth = 6;
  const auto leaks = [&](const char* light, double most) {
    for (const glm::vec3& towards : {x + y + z, -x + y - z, -x - y + 0.2F * z}) {
      inside.camera = look_at_camera(-0.2 * glm::dvec3(towards), glm::dvec3(towards), {0, 1, 0.1}, 1.5);
      const Film film = film_of(box, inside);
      EXPECT_LE(mean_of(film).mean, most) << light;
    }
  };
  box.lights = {point_light({2.5, 2, 1.5}, 1e6F)};
  leaks("point", 0);
  box.lights = {point_light(glm::dvec3(1.0001F * (x + y + z)), 1e6F)};
  leaks("point at a corner", 30);  // a ten thousandth outside: rays that begin as near to it as that graze the walls
  box.lights = {directional_light({-1, -1, -1}, 1e6F)};
  leaks("directional", 0);
  box.lights.clear();
  inside.environment.radiance = glm::vec3(1e6F);
  leaks("environment", 0);
  inside.environment = {};
  Primitive outside;
  add_quad(outside, {-3, 4, -3}, {6, 0, 0}, {0, 0, 6});
  add_mesh(box, "outside", std::move(outside), lambert(0, 1e6F));
  leaks("area", 0);
}

/// An icosahedron whose faces are split in four: 80 triangles, normals of the unit sphere.
Primitive coarse_sphere() {
  const float g = 1.6180339887F;
  const glm::vec3 v[] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                         {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const int faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                            {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                            {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  Primitive primitive;
  const auto add = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    add_triangle(primitive, glm::normalize(a), glm::normalize(b), glm::normalize(c));
    for (const glm::vec3& n : {a, b, c}) primitive.normals_object.push_back(glm::normalize(n));
  };
  for (const auto& f : faces) {
    const glm::vec3 a = glm::normalize(v[f[0]]), b = glm::normalize(v[f[1]]), c = glm::normalize(v[f[2]]);
    const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
    add(a, ab, ca), add(b, bc, ab), add(c, ca, bc), add(ab, bc, ca);
  }
  return primitive;
}

TEST(LightPunctual, G22_no_light_behind_the_geometric_horizon_and_no_step_at_the_terminator) {
  const Primitive ball = coarse_sphere();
  ASSERT_EQ(ball.indices.size(), 3U * 80);
  // One face, seen along its normal at a corner's side, where the normals lean away most.
  const glm::dvec3 a = ball.positions_object[0], b = ball.positions_object[1], c = ball.positions_object[2];
  const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a)), p = 0.9 * a + 0.05 * b + 0.05 * c;
  const glm::dvec3 lean = glm::normalize(glm::normalize(p) - n * glm::dot(n, glm::normalize(p)));
  Scene scene;
  add_mesh(scene, "ball", ball, lambert(1));
  Settings settings = settings_for(2, 2, 4);
  settings.max_depth = 2;
  settings.camera = look_at_camera(p + 0.5 * n, p, lean, 0.001);
  double last = 0, largest = 0;
  for (int step = -4; step <= 20; ++step) {
    // A light that rises over the face's plane on the side that its shading normal leans to.
    const double elevation = step * 1.0 * kPi / 180;
    scene.lights = {point_light(p + 5.0 * (std::sin(elevation) * n + std::cos(elevation) * lean), 25 * float(kPi))};
    const double seen = mean_of(film_of(scene, settings)).mean;
    if (step <= 0) {
      EXPECT_LT(seen, 1e-6) << "degrees " << step;
    }
    if (step < 0) {
      EXPECT_EQ(seen, 0) << "degrees " << step;
    }
    EXPECT_LT(std::abs(seen - last), 0.04) << "degrees " << step;
    largest = std::max(largest, seen);
    last = seen;
  }
  EXPECT_GT(largest, 0.3) << "it is lit in the end";
}

TEST(LightPunctual, G9_a_scene_and_its_lights_scaled_by_a_power_of_two_are_the_same_picture) {
  auto [scene, settings] = room(16, 16, 16);
  PunctualLight spot = point_light({0.3, 0.7, 0.5}, 2);
  spot.kind = LightKind::spot;
  spot.direction = glm::normalize(glm::dvec3(-0.3, -1, -0.2));
  spot.outer_cone_rad = 0.7;
  scene.lights = {point_light({0, 0.5, 0.5}, 1), spot};
  scene.lights[0].range_m = 3;
  const Film one = film_of(scene, settings);
  for (const double factor : {0x1p-10, 0x1p10}) {
    auto scaled = times({scene, settings}, factor);
    for (PunctualLight& light : scaled.first.lights) {
      light.position *= factor;
      light.range_m *= factor;
      light.intensity *= float(factor * factor);
    }
    EXPECT_TRUE(same_film(one, film_of(scaled.first, scaled.second))) << factor;
  }
}

}  // namespace
}  // namespace eikon::test
