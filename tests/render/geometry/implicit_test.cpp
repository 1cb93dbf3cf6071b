// SPDX-License-Identifier: Apache-2.0
// Pictures of surfaces by formula: they look as the same surfaces otherwise do, nothing leaks,
// nothing shadows itself.
#include <optional>
#include <string>

#include "formula/parse.h"
#include "gltf/animation/shutter_poses.h"
#include "render/materials/glass_builder.h"

namespace eikon::test {
namespace {

Shape& add_implicit(Scene& scene, const std::string& f, double half, const glm::dmat4& place,
                    const Material& material) {
  scene.materials.push_back(material);
  scene.formulas.push_back(formula::parse_formula(f));
  Shape shape;
  shape.name = f;
  shape.kind = ShapeKind::implicit;
  shape.size = {half, half, half};
  shape.formula = std::uint32_t(scene.formulas.size() - 1);
  shape.world_from_object = place;
  shape.material = std::uint32_t(scene.materials.size() - 1);
  return scene.shapes.emplace_back(shape);
}

glm::dmat4 askew_and_moved() {
  return glm::translate(glm::dmat4(1), {0.1, 0.2, 0.3}) * glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2)) *
         glm::scale(glm::dmat4(1), {1.0, 0.6, 0.8});
}

void expect_same(const Film& a, const Film& b, const std::string& what) {
  const Crop& crop = a.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t channel = 0; channel < 3; ++channel)
        ASSERT_EQ(a.mean(x, y, channel), b.mean(x, y, channel)) << what << ", pixel " << x << "," << y;
}

const char* const kSphere = "x^2+y^2+z^2-1";
const char* const kSheet = "max(x^2+y^2+z^2-1, (abs(sin(5*x)*cos(5*y)+sin(5*y)*cos(5*z)+sin(5*z)*cos(5*x))-0.5)/10)";

// A convex body under a constant sky shows its albedo, unless it shadows itself.
TEST(ImplicitSurface, G7_a_sphere_by_formula_shows_its_albedo_under_the_sky_from_near_and_far_at_every_size) {
  for (const double radius : {1e-5, 1.0, 1e6})
    for (const double distance : {1.5, 1e2, 1e5}) {
      Scene scene;
      const glm::dmat4 place = glm::scale(glm::dmat4(1), glm::dvec3(radius)) * askew_and_moved();
      add_implicit(scene, kSphere, 1.1, place, lambert(0.5F));
      const glm::dvec3 center(place[3]);
      Settings settings = settings_under_sky(16, 16);
      settings.camera =
          look_at_camera(center + radius * distance * glm::dvec3(0.1, 0.3, 0.95), center, {0, 1, 0}, 0.5 / distance);
      const Film film = film_of(scene, settings);
      for (std::uint32_t y = 0; y < 16; ++y)
        for (std::uint32_t x = 0; x < 16; ++x)
          ASSERT_NEAR(film.mean(x, y, 0), 0.5, 2e-6)
              << "radius " << radius << ", distance " << distance << ", pixel " << x << "," << y;
    }
}

TEST(ImplicitSurface, its_picture_is_that_of_the_analytic_sphere) {
  const auto picture = [](bool by_formula) {
    Scene scene;
    Material metal;
    metal.roughness = 0.3F;
    metal.base_color = {0.9F, 0.6F, 0.3F};
    if (by_formula) {
      add_implicit(scene, kSphere, 1.05, askew_and_moved(), metal);
    } else {
      add_implicit(scene, kSphere, 1.05, askew_and_moved(), metal).kind = ShapeKind::sphere;
      scene.shapes[0].size = {1, 0, 0};
    }
    Settings settings = settings_under_sky(32, 32);
    settings.camera = look_at_camera({0.3, 1, 3.5}, {0.1, 0.2, 0.3}, {0, 1, 0}, 0.8);
    return film_of(scene, settings);
  };
  const Film formula = picture(true), analytic = picture(false);
  double difference = 0;
  for (std::uint32_t y = 0; y < 32; ++y)
    for (std::uint32_t x = 0; x < 32; ++x) difference += std::abs(formula.mean(x, y, 0) - analytic.mean(x, y, 0));
  // The same samples: only rays within rounding of the rim differ.
  EXPECT_LT(difference / (32 * 32), 1e-4);
}

TEST(ImplicitSurface, M12_clear_glass_vanishes_in_a_constant_sky_however_often_a_ray_goes_in_and_out) {
  for (const char* f : {kSphere, kSheet}) {
    Scene scene;
    add_implicit(scene, f, 1.05, askew_and_moved(), glass(1.5F, 0, true));
    Settings settings = settings_under_sky(24, 64);
    settings.camera = look_at_camera({0, 0.5, 4}, {0.1, 0.2, 0.3}, {0, 1, 0}, 0.6);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 1)) << f;
  }
}

TEST(ImplicitSurface, a_closed_surface_is_dark_inside) {
  Scene scene;
  add_implicit(scene, kSphere, 1.05, askew_and_moved(), lambert(0.9F));
  Settings settings = settings_under_sky(32, 64);
  settings.camera = look_at_camera({0.1, 0.2, 0.32}, {1, 0.2, 0.3}, {0, 1, 0}, 2.0);
  const Film film = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 32; ++y)
    for (std::uint32_t x = 0; x < 32; ++x) ASSERT_EQ(film.mean(x, y, 0), 0) << "pixel " << x << "," << y;
}

TEST(ImplicitSurface, G9_a_scene_times_a_power_of_two_gives_the_same_bits) {
  const auto scaled = [](double factor) {
    Scene scene;
    add_implicit(scene, kSheet, 1.05, askew_and_moved(), lambert({0.7F, 0.5F, 0.3F}));
    add_implicit(scene, "(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)", 1.7,
                 glm::translate(glm::dmat4(1), {0, -1, 0}) * askew_and_moved(), glass(1.5F, 0, true));
    Settings settings = settings_under_sky(24, 8);
    settings.camera = look_at_camera({0, 0.5, 4}, {0.1, 0.2, 0.3}, {0, 1, 0}, 0.8);
    const auto [big, its] = times({std::move(scene), settings}, factor);
    return film_of(big, its);
  };
  const Film original = scaled(1);
  for (const int k : {-20, -7, 1, 20}) expect_same(original, scaled(std::ldexp(1.0, k)), "2^" + std::to_string(k));
}

// Intervals do not see that the products cancel; behind the surface in front, what is given up does
// not count.
TEST(ImplicitSurface, which_rays_give_up_hangs_on_rays_alone) {
  const auto [scene, settings] = [] {
    Scene made;
    const glm::dmat4 place = glm::scale(glm::dmat4(1), glm::dvec3(1.5));
    add_implicit(made, "x*y - x*y + 1e-5", 1, place, lambert(0.5F));
    add_implicit(made, kSphere, 1.05, glm::translate(glm::dmat4(1), {0.4, 0.2, 0.3}) * askew_and_moved(),
                 lambert(0.6F));
    Primitive floor;
    add_quad(floor, {-3, -1, 3}, {6, 0, 0}, {0, 0, -6});
    add_mesh(made, "floor", std::move(floor), lambert(0.7F));
    made.shapes[0].name = "haze";
    Settings its = settings_under_sky(12, 4);
    its.camera = look_at_camera({0.3, 1, 4}, {0, 0, 0}, {0, 1, 0}, 0.9);
    return std::pair(std::move(made), its);
  }();
  std::optional<RenderOutput> first;
  for (const Execution& way : each_way_to_trace()) {
    RenderOutput output = output_of(scene, settings, way);
    if (!first) {
      first = std::move(output);
      EXPECT_GT(first->report.search_failures, 100U);
      EXPECT_EQ(first->report.search_failure_surfaces, 1U);
      continue;
    }
    EXPECT_EQ(output.report.search_failures, first->report.search_failures)
        << way.accel << " " << way.layout << ", " << way.lanes.value_or(0) << " lanes";
    EXPECT_EQ(output.report.search_failure_surfaces, 1U);
    expect_same(output.film, first->film, way.accel + " " + way.layout);
  }
}

// A screen that moves in front of what is given up.
TEST(ImplicitSurface, what_is_given_up_behind_something_that_moves_does_not_count) {
  const auto scene_at = [](double t) {
    Scene made;
    add_implicit(made, "x*y - x*y + 1e-5", 1, glm::scale(glm::dmat4(1), glm::dvec3(1.5)), lambert(0.5F));
    made.shapes[0].name = "haze";
    Primitive screen;
    add_quad(screen, {-2, -2, 2}, {2, 0, 0}, {0, 4, 0});
    add_mesh(made, "screen", std::move(screen), lambert(0.7F)).world_from_object =
        glm::translate(glm::dmat4(1), {1.5 * t, 0, 0});
    return made;
  };
  Scene scene = scene_at(0);
  scene.animations.push_back({.name = "slide", .begin_s = 0, .end_s = 1, .channel_count = 1, .in_force = true});
  add_shutter_poses(scene, {.open_s = 0, .close_s = 1}, scene_at);
  Settings settings = settings_under_sky(12, 4);
  settings.camera = look_at_camera({0.3, 1, 4}, {0, 0, 0}, {0, 1, 0}, 0.9);
  std::optional<std::uint64_t> count;
  for (const Execution& way : each_way_to_trace()) {
    const std::uint64_t found = output_of(scene, settings, way).report.search_failures;
    if (!count) {
      EXPECT_GT(found, 100U);
    }
    EXPECT_EQ(found, count.value_or(found)) << describe(way);
    count = found;
  }
}

TEST(ImplicitSurface, emission_is_met_by_scattered_rays_alone_and_in_full) {
  // Le = 1/2 and albedo 1/2 from every side of the wall: 1.
  Scene scene;
  Material wall = lambert(0.5F, 0.5F);
  wall.double_sided = true;
  add_implicit(scene, kSphere, 1.05, askew_and_moved(), wall);
  Settings settings = settings_for(16, 16, 256);
  settings.camera = look_at_camera({0.12, 0.21, 0.33}, {1, 0.2, 0.3}, {0, 1, 0}, 2.0);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 1));
}

}  // namespace
}  // namespace eikon::test
