// SPDX-License-Identifier: Apache-2.0
// Ways of finding light differ in variance alone; error falls as it should, and the image knows its
// own.
#include "film/exr/film_file.h"
#include "image/image.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

/// The room lit by its lamp, by the sky, or by both.
std::pair<Scene, Settings> lit_by(bool lamp, bool sky, std::uint32_t side, std::uint64_t spp) {
  auto made = room(side, side, spp);
  if (!lamp)
    for (Material& material : made.first.materials) material.emission = glm::vec3(0);
  if (!sky) made.second.environment = {};
  return made;
}

struct Light {
  bool lamp, sky;
  const char* name;
};
constexpr Light kLights[] = {{true, false, "lamp"}, {false, true, "sky"}, {true, true, "both"}};

Crop quadrant(std::uint32_t side, std::uint32_t i) {
  const std::uint32_t half = side / 2, x = i % 2 * half, y = i / 2 * half;
  return {x, y, x + half, y + half};
}

TEST(LightTransport, every_way_of_finding_light_has_the_same_mean) {
  constexpr std::uint32_t side = 24;
  constexpr int comparisons = 3 * 3 * 4 * 3;
  for (const Light& light : kLights) {
    auto [scene, settings] = lit_by(light.lamp, light.sky, side, 512);
    const Film mis = film_of(scene, settings);
    for (LightSampling sampling : {LightSampling::light, LightSampling::bsdf, LightSampling::hemisphere}) {
      settings.light_sampling = sampling;
      settings.seed = 1 + static_cast<std::uint32_t>(sampling);  // independent of the other film
      settings.sample_end = sampling == LightSampling::light ? 512 : 4096;
      const Film other = film_of(scene, settings);
      for (std::uint32_t q = 0; q < 4; ++q)
        for (std::uint32_t c = 0; c < 3; ++c)
          EXPECT_TRUE(agree(mean_of(mis, c, quadrant(side, q)), mean_of(other, c, quadrant(side, q)), comparisons))
              << "lit by " << light.name << ", sampling " << static_cast<int>(sampling) << ", quadrant " << q
              << ", channel " << c;
    }
  }
}

TEST(LightTransport, mis_is_no_worse_than_twice_the_better_strategy) {
  for (const Light& light : kLights) {
    auto [scene, settings] = lit_by(light.lamp, light.sky, 24, 64);
    const auto variance = [&, made = std::pair(scene, settings)](LightSampling sampling) {
      Settings with = made.second;
      with.light_sampling = sampling;
      return std::pow(mean_of(film_of(made.first, with)).sigma, 2);
    };
    const double better = std::min(variance(LightSampling::light), variance(LightSampling::bsdf));
    EXPECT_LT(variance(LightSampling::mis), 2 * better) << light.name;
  }
}

TEST(LightTransport, hemisphere_sampling_shows_what_the_others_gain) {
  auto [scene, settings] = lit_by(true, false, 24, 64);
  const double mis = mean_of(film_of(scene, settings)).sigma;
  settings.light_sampling = LightSampling::hemisphere;
  EXPECT_GT(mean_of(film_of(scene, settings)).sigma, 3 * mis);
}

TEST(LightTransport, error_of_direct_light_falls_faster_than_that_of_random_samples) {
  const double truth = kSquareLightIrradiance / std::numbers::pi;
  Settings settings = settings_for(16, 16, 16);
  settings.camera =
      look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.001);  // all that is seen is the origin, to 2e-7
  settings.light_sampling = LightSampling::light;  // smooth; what scattered rays find is not, at the edges of the light
  std::vector<std::pair<double, double>> points;   // log samples, log rms error over pixels
  for (std::uint64_t spp : {16U, 64U, 256U, 1024U}) {
    settings.sample_end = spp;
    const Film film = film_of(square_light(), settings);
    double squares = 0;
    for (std::uint32_t i = 0; i < 256; ++i) squares += std::pow(film.mean(i % 16, i / 16, 0) - truth, 2);
    points.emplace_back(std::log(static_cast<double>(spp)), 0.5 * std::log(squares / 256));
  }
  double mean_x = 0, mean_y = 0, xy = 0, xx = 0;
  for (const auto& [x, y] : points) mean_x += x / 4, mean_y += y / 4;
  for (const auto& [x, y] : points) xy += (x - mean_x) * (y - mean_y), xx += (x - mean_x) * (x - mean_x);
  // -0.5 for independent samples, -1.5 for a scrambled net and a smooth integrand [Owen 1997].
  EXPECT_LT(xy / xx, -1.0);
  EXPECT_GT(xy / xx, -2.0) << "too good to be true";
}

TEST(LightTransport, the_predicted_error_is_the_error) {
  constexpr std::uint32_t side = 32, seeds = 960;
  auto [scene, settings] = room(side, side, 16);
  Settings long_run = settings;
  long_run.seed = 1000;
  long_run.sample_end = 8192;
  const Film truth = film_of(scene, long_run);
  const Image reference = to_image(truth);
  double predicted = 0, found = 0, variance = 0, square_error = 0;  // of the same seeds: their noise is partly the same
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    settings.seed = seed;
    const Film film = film_of(scene, settings);
    const PredictedError error = film.predicted_error();
    ASSERT_TRUE(error.known);
    EXPECT_LT(error.lo, error.relmse);
    EXPECT_GT(error.hi, error.relmse);
    predicted += error.relmse;
    found += compare_images(to_image(film), reference).relmse;
    for (std::uint32_t i = 0; i < side * side; ++i) {
      variance += film.variance_of_mean(i % side, i / side, 1);
      square_error += std::pow(film.mean(i % side, i / side, 1) - truth.mean(i % side, i / side, 1), 2);
    }
  }
  // The variance is unbiased; relMSE also estimates its denominator, which 16 samples know poorly.
  // The standard deviation of this ratio is .07 for 40 seeds, as some paths are much brighter than
  // others.
  EXPECT_NEAR(variance / square_error, 1, 0.05);
  EXPECT_NEAR(predicted / found, 1, 0.15);
}

TEST(LightTransport, direct_light_by_depth_is_a_part_of_the_whole) {
  auto [scene, settings] = room(24, 24, 16);
  settings.max_depth = 2;
  const Film two = film_of(scene, settings);
  settings.max_depth = 3;
  const Film three = film_of(scene, settings);
  // The same random numbers: each sample of depth 3 is that of depth 2 and something more.
  bool more = false;
  for (std::uint32_t y = 0; y < 24; ++y)
    for (std::uint32_t x = 0; x < 24; ++x) {
      ASSERT_GE(three.total(x, y, 0), two.total(x, y, 0));
      more = more || three.total(x, y, 0) > two.total(x, y, 0);
    }
  EXPECT_TRUE(more);
}

}  // namespace
}  // namespace eikon::test
