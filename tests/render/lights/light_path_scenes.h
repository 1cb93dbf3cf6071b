// SPDX-License-Identifier: Apache-2.0
// Scenes with a glass ball and a mirror, and settings with light paths.
#pragma once
#include <functional>

#include "render/materials/glass_builder.h"
#include "render/scene_builder.h"

namespace eikon::test {

inline Settings with_light_paths(Settings settings, double ratio) {
  settings.light_path_count = std::max<std::uint64_t>(std::uint64_t(ratio * settings.width * settings.height), 1);
  return settings;
}

/// A coarse glass ball with smooth normals, and a mirror.
inline void add_ball_and_mirror(Scene& scene) {
  add_mesh(scene, "ball", sphere({0.4F, -0.5F, 0.1F}, 0.45F, 8, false, true), glass(1.5F, 0, true));
  Material metal;
  metal.roughness = 0;
  metal.metallic = 1;
  metal.base_color = {0.9F, 0.7F, 0.5F};
  add_mesh(scene, "mirror", sphere({-0.5F, -0.55F, -0.3F}, 0.4F, 10, false, true), metal);
}

inline Settings seen_from_above(std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.camera = look_at_camera({0, 0, 1.45}, {0, -0.2, 0}, {0, 1, 0}, 1.1);
  return settings;
}

inline PunctualLight small_lamp(glm::dvec3 position, float intensity) {
  PunctualLight light;
  light.kind = LightKind::point;
  light.position = position;
  light.intensity = glm::vec3(intensity);
  return light;
}

inline PunctualLight sunshine(glm::dvec3 direction, float irradiance) {
  PunctualLight light;
  light.kind = LightKind::directional;
  light.direction = glm::normalize(direction);
  light.intensity = glm::vec3(irradiance);
  return light;
}

inline Scene closed_room_with_lamp() {
  Scene scene;
  Primitive walls, lamp;
  add_box(walls, {-1, -1, -1}, {1, 1, 1.5F}, true);
  add_quad(lamp, {-0.4F, 0.97F, -0.4F}, {0.8F, 0, 0}, {0, 0, 0.8F});
  add_mesh(scene, "walls", std::move(walls), lambert({0.6F, 0.5F, 0.4F}));
  add_mesh(scene, "lamp", std::move(lamp), lambert(0.3F, 5));
  return scene;
}

/// The ball and the mirror in a closed room with a lamp.
inline std::pair<Scene, Settings> room_of_glass(std::uint32_t side, std::uint64_t spp) {
  Scene scene = closed_room_with_lamp();
  add_ball_and_mirror(scene);
  return {std::move(scene), seen_from_above(side, spp)};
}

/// The ball and the mirror on a floor under a sky of radiance 0.1, in which one texel of 64 x 32,
/// 45 degrees high, is a sun.
inline std::pair<Scene, Settings> floor_in_the_sun(std::uint32_t side, std::uint64_t spp, float sun) {
  Scene scene;
  Primitive floor;
  add_quad(floor, {-3, -1, 3}, {6, 0, 0}, {0, 0, -6});
  add_mesh(scene, "floor", std::move(floor), lambert({0.6F, 0.5F, 0.4F}));
  add_ball_and_mirror(scene);
  auto map = std::make_shared<EnvironmentMap>();
  map->name = "sky";
  map->width = 64, map->height = 32;
  map->radiance.assign(64 * 32, glm::vec3(0.1F));
  map->radiance[8 * 64 + 40] = sun * glm::vec3(1, 0.8F, 0.6F);
  Settings settings = seen_from_above(side, spp);
  settings.environment.map = std::move(map);
  return {std::move(scene), settings};
}

/// The layers by depth of a room_of_glass have all of its light.
/// tolerance  relative
inline void expect_depths_add_up(const Scene& scene, Settings settings, double tolerance) {
  settings.aovs = {"direct", "indirect", "emission"};
  const Film film = film_of(scene, settings);
  double whole = 0, parts = 0;
  for (std::uint32_t y = 0; y < settings.height; ++y)
    for (std::uint32_t x = 0; x < settings.width; ++x) {
      whole += film.mean(x, y, 0);
      for (const char* bin : {"scattered.0.R", "scattered.1.R", "scattered.more.R"})
        parts += film.mean(x, y, film.channel_index(bin).value());
    }
  EXPECT_NEAR(parts, whole, tolerance * whole);
}

/// A way in which a scene differs from another.
struct Change {
  const char* name;
  std::function<void(Scene&, Settings&)> make;
};

inline Crop quarter(const FilmLayout& layout, std::uint32_t i) {
  const std::uint32_t w = layout.width / 2, h = layout.height / 2, x = i % 2 * w, y = i / 2 * h;
  return {x, y, x + w, y + h};
}

/// Compares quarters and channels of a picture by both ways. without_spp: samples per pixel of the
/// way without light paths, so many that both ways know the mean about equally well, as takes the
/// least time. comparisons: of the test. Returns the film with light paths.
inline Film expect_the_same_mean(const char* name, const Scene& scene, Settings settings, std::uint64_t without_spp,
                                 int comparisons) {
  settings.max_depth = 8;
  Film with = film_of(scene, with_light_paths(settings, 0.5));
  settings.seed = 7;
  settings.sample_end = without_spp;
  const Film without = film_of(scene, settings);
  for (std::uint32_t q = 0; q < 4; ++q)
    for (std::uint32_t c = 0; c < 3; ++c)
      EXPECT_TRUE(agree(mean_of(with, c, quarter(with.layout(), q)), mean_of(without, c, quarter(with.layout(), q)),
                        comparisons))
          << name << ", quarter " << q << ", channel " << c;
  return with;
}

/// Relative mean square error of the channel green, without and with light paths, against sixteen
/// times the samples with four times the light paths for each, whose own error is less than a tenth
/// of that with light paths.
inline std::pair<double, double> errors_of(const Scene& scene, Settings settings) {
  const Film without = film_of(scene, settings), with = film_of(scene, with_light_paths(settings, 1.0 / 16));
  settings.sample_end *= 16;
  settings.seed = 3;
  const Film truth = film_of(scene, with_light_paths(settings, 0.25));
  const auto error = [&](const Film& film) {
    double sum = 0;
    for (std::uint32_t y = 0; y < film.layout().height; ++y)
      for (std::uint32_t x = 0; x < film.layout().width; ++x) {
        const double expected = truth.mean(x, y, 1), difference = film.mean(x, y, 1) - expected;
        sum += difference * difference / (expected * expected + 0.01);
      }
    return sum / (double(film.layout().width) * film.layout().height);
  };
  return {error(without), error(with)};
}

inline Execution small_units() {
  Execution small;
  small.unit_paths = 256;
  small.block = 7;
  return small;
}

/// Expects that a render has the bits of `expected` whatever the way in which a device traces it.
inline void expect_the_same_bits_by_every_way(const Scene& scene, const Settings& settings, const Film& expected) {
  EXPECT_TRUE(same_film(film_of(scene, settings, small_units()), expected)) << "small units";
  Execution unfused;
  unfused.fused = false;
  EXPECT_TRUE(same_film(film_of(scene, settings, unfused), expected)) << "a launch for each stage";
  Execution queues;
  queues.lanes = 1, queues.chunked = false, queues.layout = "bvh2";
  EXPECT_TRUE(same_film(film_of(scene, settings, queues), expected)) << "queues";
  Execution alone;
  alone.threads = 1;
  EXPECT_TRUE(same_film(film_of(scene, settings, alone), expected)) << "one thread";
}

}  // namespace eikon::test
