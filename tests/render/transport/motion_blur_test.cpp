// SPDX-License-Identifier: Apache-2.0
// Pictures with an open shutter whose answers are known.
#include <functional>

#include "gltf/animation/shutter_poses.h"
#include "render/ways_to_shade.h"

namespace eikon::test {
namespace {

/// A scene that `scene_at` gives at each time of [0, 1], with the shutter open for all of it.
Scene exposed(const std::function<Scene(double)>& scene_at, std::uint32_t steps = 0) {
  Scene scene = scene_at(0.5);
  scene.animations.push_back({.name = "motion", .begin_s = 0, .end_s = 1, .channel_count = 1, .in_force = true});
  add_shutter_poses(scene, {.open_s = 0, .close_s = 1, .steps = steps}, scene_at);
  EXPECT_FALSE(scene.poses.empty());
  return scene;
}

glm::dmat4 moved_by(const glm::dvec3& way) { return glm::translate(glm::dmat4(1), way); }

/// Seen from above by parallel rays: x to the right, -z up, `side` metres across.
Settings from_above(std::uint32_t pixels, std::uint64_t spp, double side) {
  Settings settings = settings_for(pixels, pixels, spp);
  settings.camera = look_at_camera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 0.5);
  settings.camera.projection = Projection::orthographic;
  settings.camera.ymag_m = side / 2;
  return settings;
}

TEST(MotionBlur, what_moves_evenly_leaves_an_even_streak) {
  // A strip .25 m wide goes 1 m from left to right: it covers a point between for a quarter of the
  // time, and less evenly towards both ends.
  const Scene scene = exposed([](double t) {
    Scene at;
    Primitive strip;
    add_quad(strip, {-0.125F, 0, 0.9F}, {0.25F, 0, 0}, {0, 0, -1.8F});
    add_mesh(at, "strip", std::move(strip), lambert(0, 1)).world_from_object = moved_by({t - 0.5, 0, 0});
    return at;
  });
  EXPECT_EQ(scene.shutter.steps, 1U);
  const Film film = film_of(scene, from_above(32, 1024, 2));
  const auto covered = [](double x) {  // share of the time at x: the strip's middle is within an eighth of it
    return std::max(0.0, std::min(x + 0.125, 0.5) - std::max(x - 0.125, -0.5));
  };
  for (std::uint32_t x = 0; x < 32; ++x) {
    const double left = (double(x) - 16) / 16;
    double expected = 0;
    for (int i = 0; i < 64; ++i) expected += covered(left + (i + 0.5) / 1024) / 64;
    const MeanAndError found = mean_of(film, 0, {x, 4, x + 1, 28});
    if (expected == 0)
      EXPECT_EQ(found.mean, 0) << x;
    else
      EXPECT_TRUE(agrees(found, expected, 20, 1e-4)) << x;
  }
}

/// A disc of 64 triangles around the origin whose half for z < 0 shines.
Scene half_disc(double turn_rad) {
  Primitive bright, dark;
  for (int i = 0; i < 64; ++i) {
    const auto corner = [](int k) { return glm::vec3(std::cos(2 * kPi * k / 64), 0, -std::sin(2 * kPi * k / 64)); };
    add_triangle(i < 32 ? bright : dark, {0, 0, 0}, corner(i), corner(i + 1));
  }
  Scene scene;
  for (auto* half : {&bright, &dark})
    add_mesh(scene, "disc", std::move(*half), lambert(0, half == &bright ? 1 : 0)).world_from_object =
        glm::rotate(glm::dmat4(1), turn_rad, glm::dvec3(0, 1, 0));
  return scene;
}

TEST(MotionBlur, a_disc_that_spins_shows_the_mean_of_each_ring) {
  const Scene scene = exposed([](double t) { return half_disc(2 * kPi * t); });
  EXPECT_GE(scene.shutter.steps, 32U) << "its rim goes round, not through";
  const Film film = film_of(scene, from_above(32, 256, 2));
  for (const Crop& window : {Crop{4, 14, 8, 18}, Crop{10, 10, 13, 13}, Crop{16, 3, 20, 6}, Crop{22, 20, 26, 24}})
    EXPECT_TRUE(agrees(mean_of(film, 0, window), 0.5, 4, 1e-3)) << window.x0;
  // A quarter of a turn: points that the bright half sweeps have the share of the time that it is
  // over them.
  const Scene quarter = exposed([](double t) { return half_disc(kPi / 2 * t); });
  const Film swept = film_of(quarter, from_above(32, 256, 2));
  EXPECT_TRUE(agrees(mean_of(swept, 0, {9, 4, 11, 6}), 1, 4, 1e-3));  // up and left
  EXPECT_EQ(mean_of(swept, 0, {22, 25, 24, 27}).mean, 0);             // down and right
  // On the diagonal down and left, and up and right, half of the time.
  EXPECT_TRUE(agrees(mean_of(swept, 0, {8, 22, 10, 24}), 0.5, 4, 1e-3));
  EXPECT_TRUE(agrees(mean_of(swept, 0, {22, 8, 24, 10}), 0.5, 4, 1e-3));
}

TEST(MotionBlur, a_scene_that_moves_with_its_camera_shows_the_still) {
  auto [still, settings] = room(24, 24, 256);
  const glm::dvec3 way(0.7, -0.3, 0.4);
  const Scene& original = still;
  const Scene moving = exposed(
      [&](double t) {
        Scene at = original;
        for (Node& node : at.nodes) node.world_from_object = moved_by(way * (t - 0.5)) * node.world_from_object;
        return at;
      },
      4);
  Settings with_camera = settings;
  for (int k = 0; k <= 4; ++k) {
    Camera pose = settings.camera;
    pose.world_from_camera = moved_by(way * (k / 4.0 - 0.5)) * pose.world_from_camera;
    with_camera.camera_poses.push_back(pose);
  }
  const Film a = film_of(moving, with_camera), b = film_of(still, settings);
  for (std::uint32_t c = 0; c < 3; ++c)
    for (const Crop& window : {Crop{0, 0, 12, 12}, Crop{12, 0, 24, 12}, Crop{0, 12, 12, 24}, Crop{12, 12, 24, 24}})
      EXPECT_TRUE(agree(mean_of(a, c, window), mean_of(b, c, window), 12)) << c;
}

/// A white floor of 40 cm, seen at the origin.
Scene floor_of_paper() {
  Primitive floor;
  add_quad(floor, {-0.2F, 0, 0.2F}, {0.4F, 0, 0}, {0, 0, -0.4F});
  Scene scene;
  add_mesh(scene, "floor", std::move(floor), lambert(0.5F));
  return scene;
}

Settings at_the_origin(std::uint64_t spp) {
  Settings settings = settings_for(8, 8, spp);
  settings.camera = look_at_camera({0, 0.15, 0}, {0, 0, 0}, {0, 0, -1}, 1e-3);
  settings.max_depth = 2;
  return settings;
}

double mean_over_time(const std::function<double(double)>& at) {
  constexpr int kTimes = 1000;
  double sum = 0;
  for (int i = 0; i < kTimes; ++i) sum += at((i + 0.5) / kTimes);
  return sum / kTimes;
}

TEST(MotionBlur, a_lamp_that_moves_lights_by_the_integral_over_time) {
  const auto place = [](double t) { return glm::dvec3(2 * t - 0.5, 1 + t, 0.3); };
  for (const LightKind kind : {LightKind::point, LightKind::directional}) {
    const auto axis = [&](double t) { return glm::normalize(glm::dvec3(0.2 * t, -1, 0)); };
    const Scene scene = exposed(
        [&](double t) {
          Scene at = floor_of_paper();
          PunctualLight lamp;
          lamp.kind = kind;
          lamp.intensity = glm::vec3(3);
          lamp.position = place(t);
          lamp.direction = axis(t);
          at.lights = {lamp};
          return at;
        },
        8);
    EXPECT_TRUE(scene.moves_lights);
    const double expected = 0.5 / kPi * mean_over_time([&](double t) {
                              if (kind == LightKind::directional) return -3 * axis(t).y;
                              const glm::dvec3 p = place(t);
                              return 3 * p.y / std::pow(glm::length(p), 3);
                            });
    EXPECT_TRUE(agrees(mean_of(film_of(scene, at_the_origin(256))), expected, 2, 2e-3)) << int(kind);
  }
}

TEST(MotionBlur, a_spot_that_turns_lights_for_the_time_that_its_cone_holds_the_point) {
  // The axis turns from 0 to 40 degrees within 32 steps; the cone of 20 degrees, without a soft
  // rim, leaves half way.
  const Scene scene = exposed(
      [&](double t) {
        Scene at = floor_of_paper();
        PunctualLight lamp;
        lamp.kind = LightKind::spot;
        lamp.intensity = glm::vec3(1);
        lamp.position = {0, 1, 0};
        const double angle = t * kPi / 4.5;
        lamp.direction = {std::sin(angle), -std::cos(angle), 0};
        lamp.inner_cone_rad = lamp.outer_cone_rad = kPi / 9;
        at.lights = {lamp};
        return at;
      },
      32);
  // KHR_lights_punctual has a rim of .001 in the cosine at least, where the square of what is left
  // of it is passed: a third of the light.
  const double rim = 0.001 / std::sin(kPi / 9), lit = 0.5 - 2.0 / 3 * rim / (kPi / 4.5);
  EXPECT_TRUE(agrees(mean_of(film_of(scene, at_the_origin(1024))), lit * 0.5 / kPi, 1, 5e-4));
}

/// Irradiance at the origin of a square that faces down around p, of radiance 1.
double irradiance_of_square(const glm::dvec3& p, double side) {
  constexpr int kCells = 24;
  double sum = 0;
  for (int i = 0; i < kCells; ++i)
    for (int k = 0; k < kCells; ++k) {
      const glm::dvec3 q = p + side * glm::dvec3((i + 0.5) / kCells - 0.5, 0, (k + 0.5) / kCells - 0.5);
      sum += q.y * q.y / std::pow(glm::dot(q, q), 2);
    }
  return sum * side * side / (kCells * kCells);
}

TEST(MotionBlur, a_surface_that_shines_moves_and_grows_has_its_exact_density_at_each_time) {
  const auto place = [](double t) { return glm::dvec3(1.2 * t - 0.4, 0.8, 0.2); };
  const auto side = [](double t) { return 0.3 + 0.9 * t; };
  const Scene scene = exposed([&](double t) {
    Scene at = floor_of_paper();
    Primitive lamp;
    add_quad(lamp, {-0.5F, 0, -0.5F}, {1, 0, 0}, {0, 0, 1});  // its front faces down
    add_mesh(at, "lamp", std::move(lamp), lambert(0, 1)).world_from_object =
        moved_by(place(t)) * glm::scale(glm::dmat4(1), glm::dvec3(side(t)));
    return at;
  });
  const double expected = 0.5 / kPi * mean_over_time([&](double t) { return irradiance_of_square(place(t), side(t)); });
  for (const LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    Settings settings = at_the_origin(4096);
    settings.light_sampling = sampling;
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected, 3, 1e-3)) << name_of(sampling);
  }
}

/// A room in which a block turns, the ball moves, and the lamp swings.
std::pair<Scene, Settings> room_in_motion() {
  auto [still, settings] = room(20, 16, 16);
  const Scene& original = still;
  Scene scene = exposed([&](double t) {
    Scene at = original;
    for (Node& node : at.nodes) {
      if (node.name == "block")
        node.world_from_object = node.world_from_object * glm::rotate(glm::dmat4(1), t, {0, 1, 0});
      if (node.name == "ball" || node.name == "lamp") node.world_from_object = moved_by({0.2 * t, 0, -0.1 * t});
    }
    return at;
  });
  for (std::uint32_t k = 0; k <= scene.shutter.steps; ++k) {
    Camera pose = settings.camera;
    pose.world_from_camera = pose.world_from_camera * glm::rotate(glm::dmat4(1), 0.02 * k, {0, 1, 0});
    settings.camera_poses.push_back(pose);
  }
  return {std::move(scene), settings};
}

TEST(MotionBlur, the_bits_are_the_same_however_it_is_traced_and_shared_out) {
  auto [scene, settings] = room_in_motion();
  const Film whole = film_of(scene, settings);
  for (const Execution& way : ways_to_shade())
    EXPECT_TRUE(same_film(film_of(scene, settings, way), whole)) << describe(way);
  Settings part = settings;
  part.crop = {3, 2, 11, 9};
  EXPECT_TRUE(same_window(whole, film_of(scene, part)));
  Settings first = settings, second = settings;
  first.sample_end = second.sample_begin = 5;
  Film sum = film_of(scene, first);
  sum.add(film_of(scene, second));
  EXPECT_TRUE(same_film(sum, whole));
}

TEST(MotionBlur, a_scene_that_does_not_move_needs_no_feature_of_it) {
  auto [scene, settings] = room(8, 8, 4);
  const std::string still = Features(scene, settings).summary();
  scene.animations.push_back({.name = "rest", .begin_s = 0, .end_s = 1, .channel_count = 1, .in_force = true});
  const Scene original = scene;
  add_shutter_poses(scene, {.open_s = 0, .close_s = 1}, [&](double) { return original; });
  EXPECT_TRUE(scene.poses.empty());
  EXPECT_EQ(Features(scene, settings).summary(), still);
  EXPECT_TRUE(same_film(film_of(scene, settings), film_of(original, settings)));
}

}  // namespace
}  // namespace eikon::test
