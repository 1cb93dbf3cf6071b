// SPDX-License-Identifier: Apache-2.0
// Pictures lit by a map: each way of finding its light has the mean that the map's definition
// gives.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

Environment sky_of(std::uint32_t width, std::uint32_t height, std::vector<glm::vec3> radiance, double rotation = 0) {
  auto map = std::make_shared<EnvironmentMap>();
  map->name = "sky";
  map->width = width;
  map->height = height;
  map->radiance = std::move(radiance);
  Environment environment;
  environment.map = std::move(map);
  environment.rotation_rad = rotation;
  return environment;
}

Environment hot_texel(std::uint32_t width, std::uint32_t height, std::uint32_t i, std::uint32_t j, float hot,
                      float rest, double rotation = 0) {
  std::vector<glm::vec3> texels(std::size_t{width} * height, glm::vec3(rest, 2 * rest, 0));
  texels[std::size_t{j} * width + i] = glm::vec3(hot, 0.5F * hot, hot);
  return sky_of(width, height, std::move(texels), rotation);
}

/// Irradiance, channel c, of a surface of normal n: the bilinear interpolation by the midpoint
/// rule, in double precision.
double irradiance(const Environment& environment, glm::dvec3 n, int c) {
  const EnvironmentMap& map = *environment.map;
  const auto texel = [&](int i, int j) {
    const int w = int(map.width), h = int(map.height);
    return double(map.radiance[std::size_t(std::clamp(j, 0, h - 1) * w + (i + w) % w)][c]) * environment.scale;
  };
  constexpr int columns = 1536, rows = 1536;
  double sum = 0;
  for (int b = 0; b < rows; ++b) {
    const double polar = kPi * (b + 0.5) / rows, y = (b + 0.5) / rows * map.height - 0.5;
    const int j = int(std::floor(y));
    for (int a = 0; a < columns; ++a) {
      const double azimuth = 2 * kPi * ((a + 0.5) / columns - 0.5) - environment.rotation_rad;
      const glm::dvec3 d(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth));
      const double cosine = glm::dot(d, n);
      if (cosine <= 0) continue;
      const double x = (a + 0.5) / columns * map.width - 0.5;
      const int i = int(std::floor(x));
      const double tx = x - i, ty = y - j;
      const double radiance = (1 - ty) * ((1 - tx) * texel(i, j) + tx * texel(i + 1, j)) +
                              ty * ((1 - tx) * texel(i, j + 1) + tx * texel(i + 1, j + 1));
      sum += radiance * cosine * std::sin(polar);
    }
  }
  return sum * kPi / rows * 2 * kPi / columns;
}

/// A white square of normal n around the origin, seen along -n.
std::pair<Scene, Settings> plate(glm::dvec3 n, const Environment& environment, std::uint64_t spp) {
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0.3, 0.5, -0.8), n)), y = glm::cross(n, x);
  Primitive square;
  add_quad(square, glm::vec3(-x - y), glm::vec3(2.0 * x), glm::vec3(2.0 * y));
  Scene scene;
  add_mesh(scene, "plate", std::move(square), lambert(1));
  Settings settings = settings_for(16, 16, spp);
  settings.camera = look_at_camera(2.0 * n, {0, 0, 0}, y, 0.4);
  settings.environment = environment;
  return {std::move(scene), settings};
}

TEST(LightEnvironment, L14_hot_texels_at_pole_seam_and_horizon_by_each_way_of_finding_them) {
  struct Case {
    const char* name;
    Environment environment;
    glm::dvec3 n;
    std::uint64_t cosine_spp;  // what scattered rays alone need to find it
  };
  const glm::dvec3 slanted = glm::normalize(glm::dvec3(0.4, 0.7, 0.6));
  const Case cases[] = {
      {"one texel for all", sky_of(1, 1, {glm::vec3(1, 2, 3)}, 1), slanted, 64},
      {"pole row", hot_texel(16, 8, 3, 0, 65536, 1), {0, 1, 0}, 4096},
      {"other pole", hot_texel(16, 8, 9, 7, 65536, 1, 2), glm::normalize(glm::dvec3(0.2, -1, 0.1)), 4096},
      {"seam", hot_texel(16, 8, 0, 3, 65536, 1), slanted, 4096},
      {"seam from its other side, turned", hot_texel(16, 8, 15, 3, 65536, 1, 0.5), slanted, 4096},
      {"nothing else", hot_texel(16, 8, 8, 2, 10, 0), {0, 0.6, -0.8}, 4096},
      {"sun of a sky", hot_texel(256, 128, 64, 30, 65536, 1), {0, 1, 0}, 0},
  };
  constexpr int comparisons = 7 * 4 * 3;
  for (const Case& c : cases)
    for (LightSampling sampling :
         {LightSampling::mis, LightSampling::light, LightSampling::bsdf, LightSampling::hemisphere}) {
      const bool by_chance = sampling == LightSampling::bsdf || sampling == LightSampling::hemisphere;
      if (by_chance && c.cosine_spp == 0) continue;
      auto [scene, settings] = plate(c.n, c.environment, by_chance ? c.cosine_spp : 256);
      settings.light_sampling = sampling;
      const Film film = film_of(scene, settings);
      for (int channel = 0; channel < 3; ++channel) {
        const double expected = irradiance(c.environment, c.n, channel) / kPi;
        if (expected == 0) {
          EXPECT_EQ(mean_of(film, std::uint32_t(channel)).mean, 0);
          continue;
        }
        EXPECT_TRUE(agrees(mean_of(film, std::uint32_t(channel)), expected, comparisons, 2e-5))
            << c.name << ", sampling " << int(sampling) << ", channel " << channel;
      }
    }
}

TEST(LightEnvironment, mis_is_no_worse_than_twice_the_better_strategy_under_suns_of_any_strength) {
  for (const float hot : {30.0F, 1000.0F, 65536.0F}) {
    auto [scene, settings] = plate({0, 1, 0}, hot_texel(16, 8, 5, 2, hot, 1), 256);
    const auto variance = [&, made = std::pair(scene, settings)](LightSampling sampling) {
      Settings with = made.second;
      with.light_sampling = sampling;
      return std::pow(mean_of(film_of(made.first, with)).sigma, 2);
    };
    const double better = std::min(variance(LightSampling::light), variance(LightSampling::bsdf));
    EXPECT_LT(variance(LightSampling::mis), 2 * better) << hot;
  }
}

TEST(LightEnvironment, L13_an_even_map_is_a_constant_environment) {
  auto [scene, settings] = room(24, 24, 512);
  for (Material& material : scene.materials) material.emission = glm::vec3(0);
  const Film constant = film_of(scene, settings);
  settings.environment = sky_of(8, 4, std::vector<glm::vec3>(32, glm::vec3(0.3F, 0.4F, 0.6F)), 1);
  settings.seed = 1;
  const Film map = film_of(scene, settings);
  for (std::uint32_t c = 0; c < 3; ++c) EXPECT_TRUE(agree(mean_of(constant, c), mean_of(map, c), 3)) << c;
}

TEST(LightEnvironment, the_camera_sees_the_map_as_it_was_drawn_and_turned) {
  // Twelve columns of their own brightness, two rows.
  std::vector<glm::vec3> texels(24);
  for (std::size_t i = 0; i < 24; ++i) texels[i] = glm::vec3(float(1 + i % 12), i < 12 ? 1.0F : 0.0F, 0);
  for (const double turns : {0.0, 0.25, -1.0 / 3}) {
    Settings settings = settings_for(8, 8, 16);
    settings.environment = sky_of(12, 2, texels, 2 * kPi * turns);
    for (int column = 0; column < 12; ++column) {
      // The middle of the column, turned about +Y: what is at -Z goes towards -X.
      const double azimuth = 2 * kPi * ((column + 0.5) / 12 - 0.5 - turns);
      const glm::dvec3 d(std::sin(azimuth), 0, -std::cos(azimuth));
      settings.camera = look_at_camera({0, 0, 0}, d, {0, 1, 0}, 0.01);
      const Film film = film_of(Scene{}, settings);
      const MeanAndError seen = mean_of(film, 0);
      EXPECT_NEAR(seen.mean, column + 1, 0.05) << turns;
      EXPECT_NEAR(mean_of(film, 1).mean, 0.5, 0.01) << "the horizon lies between the rows";
      EXPECT_LT(film.mean(4, 7, 1), film.mean(4, 0, 1)) << "up is up";
    }
  }
}

TEST(LightEnvironment, L15_a_black_map_is_black_and_a_lamp_under_it_shines_alone) {
  const Environment black = sky_of(4, 2, std::vector<glm::vec3>(8, glm::vec3(0)));
  for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    auto [scene, settings] = plate({0, 1, 0}, black, 16);
    settings.light_sampling = sampling;
    const Film film = film_of(scene, settings);
    for (std::uint32_t i = 0; i < 256; ++i) ASSERT_EQ(film.total(i % 16, i / 16, 0), 0);
  }
  Settings settings = settings_for(16, 16, 256);
  settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
  settings.environment = black;
  EXPECT_TRUE(agrees(mean_of(film_of(square_light(), settings)), kSquareLightIrradiance / kPi, 1));
}

TEST(LightEnvironment, map_and_lamp_together_give_the_sum_of_each) {
  Settings settings = settings_for(16, 16, 1024);
  settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
  const Environment sky = hot_texel(16, 8, 3, 3, 50, 0.1F);  // seen beside the lamp
  settings.environment = sky;
  const MeanAndError both = mean_of(film_of(square_light(), settings));
  settings.seed = 1;
  Scene dark = square_light();
  for (Material& material : dark.materials) material.emission = glm::vec3(0);
  const MeanAndError alone = mean_of(film_of(dark, settings));
  EXPECT_TRUE(agree(both, {alone.mean + kSquareLightIrradiance / kPi, alone.sigma}, 1));
  EXPECT_GT(alone.mean, 0.01);
}

}  // namespace
}  // namespace eikon::test
