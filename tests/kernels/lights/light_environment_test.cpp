// SPDX-License-Identifier: Apache-2.0
// The environment's map: looked up and sampled as its definition says, worked out here in double
// precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "core/error.h"
#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "pack/frame.h"
#include "pack/lights/light_table.h"
#include "pack/lights/pack_environment.h"

namespace eikon::test {
namespace {

using std::numbers::pi;
constexpr std::uint32_t kMap = 2;  // bit of EK_LIGHT(environment_map)

using Directions = std::array<std::vector<double>, 3>;

/// A map on its way to the kernels, as the only light.
struct Sky {
  Environment environment;
  PackedScene packed;
  Frame frame{};
  double integral = 0;

  Sky(std::uint32_t width, std::uint32_t height, std::vector<glm::vec3> radiance, double rotation = 0) {
    auto map = std::make_shared<EnvironmentMap>();
    map->name = "test";
    map->width = width;
    map->height = height;
    map->radiance = std::move(radiance);
    environment.map = std::move(map);
    environment.rotation_rad = rotation;
    integral = pack_environment_map(environment, packed);
    Settings settings;
    settings.width = settings.height = 1;
    settings.environment = environment;
    frame = pack_frame(packed, settings);
    frame.light_count = 1;
  }

  [[nodiscard]] std::uint32_t width() const { return environment.map->width; }
  [[nodiscard]] std::uint32_t height() const { return environment.map->height; }
  [[nodiscard]] double pdf(std::size_t texel) const { return double(packed.environment_texels[texel].w); }

  /// In texels, as environment_map.h defines it.
  [[nodiscard]] std::array<double, 2> place(double x, double y, double z) const {
    const double a = environment.rotation_rad;
    const double map_x = x * std::cos(a) - z * std::sin(a), map_z = x * std::sin(a) + z * std::cos(a);
    return {(std::atan2(map_x, -map_z) / (2 * pi) + 0.5) * width(), std::atan2(std::hypot(x, z), y) / pi * height()};
  }

  [[nodiscard]] double radiance(const std::array<double, 2>& place, int channel) const {
    const auto texel = [&](double i, double j) {
      const auto column = std::size_t(i < 0 ? i + width() : i >= width() ? i - width() : i);
      const auto row = std::size_t(std::clamp(j, 0.0, height() - 1.0));
      return double(environment.map->radiance[row * width() + column][channel]) * environment.scale;
    };
    const double x = place[0] - 0.5, y = place[1] - 0.5, i = std::floor(x), j = std::floor(y), tx = x - i, ty = y - j;
    return (1 - ty) * ((1 - tx) * texel(i, j) + tx * texel(i + 1, j)) +
           ty * ((1 - tx) * texel(i, j + 1) + tx * texel(i + 1, j + 1));
  }
};

std::vector<glm::vec3> speckled(std::uint32_t width, std::uint32_t height, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<glm::vec3> texels(std::size_t{width} * height);
  for (glm::vec3& texel : texels)
    for (int c = 0; c < 3; ++c) {
      const double x = double(random()) / 4294967296.0;
      texel[c] = random() % 4 == 0 ? 0.0F : float(std::pow(10.0, 3 * x - 1));
    }
  return texels;
}

std::vector<glm::vec3> one_lit(std::uint32_t width, std::uint32_t height, std::uint32_t i, std::uint32_t j, float hot,
                               float rest = 0) {
  std::vector<glm::vec3> texels(std::size_t{width} * height, glm::vec3(rest));
  texels[std::size_t{j} * width + i] = glm::vec3(hot);
  return texels;
}

std::vector<Sky> skies() {
  std::vector<Sky> list;
  list.emplace_back(1, 1, std::vector<glm::vec3>{{1, 2, 3}});
  list.emplace_back(16, 8, speckled(16, 8, 1));
  list.emplace_back(7, 5, speckled(7, 5, 2), 0.7);
  list.emplace_back(12, 6, one_lit(12, 6, 5, 0, 65536, 1), -2.5);  // pole row
  list.emplace_back(12, 6, one_lit(12, 6, 3, 5, 65536, 1));        // the other
  list.emplace_back(12, 6, one_lit(12, 6, 0, 3, 65536, 1), 0.1);   // seam column
  list.emplace_back(12, 6, one_lit(12, 6, 11, 2, 1));              // and nothing else
  list.emplace_back(64, 1, speckled(64, 1, 3));
  list.emplace_back(1, 64, speckled(1, 64, 4));
  list.emplace_back(2048, 3, speckled(2048, 3, 5));
  list.emplace_back(3, 2048, speckled(3, 2048, 6));
  return list;
}

struct MapSample {
  std::array<double, 3> wi, radiance;
  double pdf, pdf_asked;
};

std::vector<MapSample> sample(const Sky& sky, std::mt19937& random, std::size_t count) {
  Light light{};
  light.kind = kMap;
  light.pdf_m2 = 1;
  std::vector<Words> in;
  const auto constant = [&](float x) { in.emplace_back(count, as_word(x)); };
  const auto words = [&] {
    in.emplace_back();
    for (std::size_t i = 0; i < count; ++i) in.back().push_back(std::uint32_t(random()));
  };
  words(), words();
  for (const float x : {0.F, 0.F, 0.F, 0.F, 0.F, 0.F, 0.F, 0.F, 1.F, 0.F}) constant(x);
  words(), words();
  const auto out = Probe("light")
                       .buffer("frame", std::vector<Frame>{sky.frame})
                       .buffer("lights", std::vector<Light>{light})
                       .buffer("light_alias_table", build_light_table(std::vector<double>{1}).buckets)
                       .buffer("environment_texels", sky.packed.environment_texels)
                       .buffer("environment_alias_table", sky.packed.environment_alias_table)
                       .without_light_paths()
                       .run("probe_light", in, 27);
  std::vector<MapSample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    const auto f = [&](std::size_t k) { return double(as_float(out[k][i])); };
    EXPECT_TRUE(out[0][i] == 1 && out[26][i] == 0 && std::isinf(f(21))) << "distant, can be met, no end";
    samples.push_back(
        {.wi = {f(11), f(12), f(13)}, .radiance = {f(23), f(24), f(25)}, .pdf = f(14), .pdf_asked = f(22)});
  }
  return samples;
}

/// Integral over all directions of a function of (place, direction), by the midpoint rule in each
/// cell's quarters, linear in azimuth and cosine.
template <class Function>
double integrate(const Sky& sky, Function f) {
  const std::uint32_t per = sky.width() * sky.height() > 1000 ? 8 : 256;
  double sum = 0;
  for (std::uint32_t j = 0; j < sky.height(); ++j) {
    const double top = std::cos(pi * j / sky.height()), bottom = std::cos(pi * (j + 1) / sky.height());
    for (std::uint32_t b = 0; b < per; ++b) {
      const double cosine = top + (b + 0.5) / per * (bottom - top), y = std::acos(cosine) / pi * sky.height();
      for (std::uint32_t a = 0; a < sky.width() * per; ++a)
        sum += f(std::array{(a + 0.5) / per, y}, cosine) * (top - bottom) / per * 2 * pi / (sky.width() * per);
    }
  }
  return sum;
}

TEST(EnvironmentMap, densities_integrate_to_one_and_vanish_only_where_the_interpolation_does) {
  for (const Sky& sky : skies()) {
    double sum = 0;
    for (std::uint32_t j = 0; j < sky.height(); ++j)
      for (std::uint32_t i = 0; i < sky.width(); ++i) {
        const double pdf = sky.pdf(std::size_t{j} * sky.width() + i);
        // By the cosines themselves: what the product of sines in pack_environment.cpp stands for.
        const double solid_angle =
            2 * pi / sky.width() * (std::cos(pi * j / sky.height()) - std::cos(pi * (j + 1) / sky.height()));
        EXPECT_NEAR(texel_solid_angle(j, sky.width(), sky.height()) / solid_angle, 1, 1e-8);
        sum += pdf * solid_angle;
        bool lit = false;
        for (const double x : {0.01, 0.5, 0.99})
          for (const double y : {0.01, 0.5, 0.99})
            for (int c = 0; c < 3; ++c) lit = lit || sky.radiance({i + x, j + y}, c) > 0;
        ASSERT_EQ(pdf > 0, lit) << i << ", " << j << " of " << sky.width() << " x " << sky.height();
      }
    EXPECT_NEAR(sum, 1, 1e-6) << sky.width() << " x " << sky.height();
  }
}

TEST(EnvironmentMap, M1_directions_have_the_density_of_their_texel_to_the_poles) {
  constexpr std::size_t kSamples = 400000;
  const std::vector<Sky> list = skies();
  std::mt19937 random(21);
  for (const Sky& sky : list) {
    // Each cell in quarters of equal solid angle.
    std::vector<double> observed(4 * std::size_t{sky.width()} * sky.height(), 0), expected;
    for (std::uint32_t j = 0; j < sky.height(); ++j)
      for (std::uint32_t i = 0; i < sky.width(); ++i) {
        const double share =
            sky.pdf(std::size_t{j} * sky.width() + i) * texel_solid_angle(j, sky.width(), sky.height());
        expected.insert(expected.end(), 4, share / 4 * kSamples);
      }
    std::size_t strayed = 0;
    for (const MapSample& s : sample(sky, random, kSamples)) {
      const auto [x, y] = sky.place(s.wi[0], s.wi[1], s.wi[2]);
      const auto i = std::min(std::uint32_t(x), sky.width() - 1), j = std::min(std::uint32_t(y), sky.height() - 1);
      const double top = std::cos(pi * j / sky.height()), bottom = std::cos(pi * (j + 1) / sky.height());
      const double down = std::clamp((top - s.wi[1]) / (top - bottom), 0.0, 1.0);
      const std::size_t texel = std::size_t{j} * sky.width() + i;
      ASSERT_GT(s.pdf, 0);
      ASSERT_NEAR(s.wi[0] * s.wi[0] + s.wi[1] * s.wi[1] + s.wi[2] * s.wi[2], 1, 1e-6);
      if (expected[4 * texel] == 0) {
        ++strayed;  // the direction's rounding took it over the border of a dark texel
        continue;
      }
      ++observed[4 * texel + (x - i < 0.5 ? 0 : 1) + (down < 0.5 ? 0 : 2)];
    }
    EXPECT_LT(double(strayed), 1e-6 * std::max(sky.width(), sky.height()) * kSamples + 10);
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(list.size())) << sky.width() << " x " << sky.height() << "\n" << test.table;
  }
}

TEST(EnvironmentMap, density_asked_for_is_that_of_sampling_but_for_rounding_at_the_cells_borders) {
  std::mt19937 random(22);
  for (const Sky& sky : skies()) {
    const double side = std::max(sky.width(), sky.height());
    std::size_t inside = 0;
    for (const MapSample& s : sample(sky, random, 100000)) {
      const auto [x, y] = sky.place(s.wi[0], s.wi[1], s.wi[2]);
      const double border = std::min(std::abs(x - std::nearbyint(x)), std::abs(y - std::nearbyint(y)));
      const double near_pole = std::min(y, sky.height() - y) / sky.height();
      if (border < 4e-7 * side / std::min(1.0, near_pole * 3)) continue;
      ++inside;
      ASSERT_EQ(s.pdf, s.pdf_asked) << x << ", " << y << " of " << sky.width() << " x " << sky.height();
    }
    EXPECT_GT(inside, 90000U);
  }
}

TEST(EnvironmentMap, lookup_is_the_bilinear_interpolation_at_poles_and_seam_too) {
  std::mt19937 random(23);
  for (const Sky& sky : skies()) {
    std::vector<Words> in(3);
    const auto add = [&](double x, double y, double z) {
      const double length = std::sqrt(x * x + y * y + z * z);
      for (const auto& [k, value] : {std::pair(0, x), std::pair(1, y), std::pair(2, z)})
        in[std::size_t(k)].push_back(as_word(float(value / length)));
    };
    for (int i = 0; i < 20000; ++i) {
      const auto unit = [&] { return 2 * double(random()) / 4294967296.0 - 1; };
      add(unit(), unit(), unit());
      add(1e-4 * unit(), i % 2 == 0 ? 1 : -1, 1e-4 * unit());
      add(1e-4 * unit(), unit(), 1);
    }
    for (const double s : {1.0, -1.0}) add(s, 0, 0), add(0, s, 0), add(0, 0, s), add(-0.0, s, -0.0), add(-0.0, 0, s);
    const auto out = Probe("light")
                         .buffer("frame", std::vector<Frame>{sky.frame})
                         .buffer("environment_texels", sky.packed.environment_texels)
                         .run("probe_environment_map", in, 7);
    float brightest = 0;
    for (const glm::vec3& texel : sky.environment.map->radiance)
      brightest = std::max({brightest, texel.x, texel.y, texel.z});
    for (std::size_t i = 0; i < in[0].size(); ++i) {
      const auto place = sky.place(double(as_float(in[0][i])), double(as_float(in[1][i])), double(as_float(in[2][i])));
      ASSERT_LT(out[6][i], sky.width() * sky.height());
      // The seam is one place with two names, and a rounded rotation turns what is beside a pole
      // around it.
      const double off = std::remainder(double(as_float(out[4][i])) - place[0], sky.width());
      const double near_pole = std::hypot(double(as_float(in[0][i])), double(as_float(in[2][i])));
      const double tolerance = 3e-7 * sky.width() * (1 + 1e-7 / std::max(near_pole, 1e-30));
      ASSERT_NEAR(double(as_float(out[5][i])), place[1], 2e-7 * sky.height());
      if (near_pole < 1e-6) continue;
      ASSERT_LT(std::abs(off), tolerance) << place[0] << ", " << place[1];
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(double(as_float(out[std::size_t(c)][i])), sky.radiance(place, c),
                    2 * (tolerance + 2e-7 * sky.height() + 1e-6) * double(brightest))
            << place[0] << ", " << place[1] << " of " << sky.width() << " x " << sky.height();
      }
    }
  }
}

TEST(EnvironmentMap, positive_rotation_takes_what_is_ahead_to_the_left) {
  const Sky sky(64, 32, one_lit(64, 32, 32, 16, 1), pi / 2);  // just right of the middle, just below the horizon
  const auto out =
      Probe("light")
          .buffer("frame", std::vector<Frame>{sky.frame})
          .buffer("environment_texels", sky.packed.environment_texels)
          .run("probe_environment_map", {as_words({0, 0, -1, 1}), as_words({0, 0, 0, 0}), as_words({-1, 1, 0, 0})}, 7);
  EXPECT_EQ(as_float(out[0][0]), 0);
  EXPECT_EQ(as_float(out[0][1]), 0);
  EXPECT_NEAR(as_float(out[0][2]), 0.25, 1e-4) << "-Z moves to -X; half a texel off along both axes";
  EXPECT_EQ(as_float(out[0][3]), 0);
}

TEST(EnvironmentMap, L14_sampled_power_and_irradiance_are_those_of_the_interpolation) {
  std::mt19937 random(24);
  for (const Sky& sky : skies()) {
    const double power = integrate(sky, [&](const auto& place, double) { return sky.radiance(place, 1); });
    const double irradiance = integrate(
        sky, [&](const auto& place, double cosine) { return std::max(cosine, 0.0) * sky.radiance(place, 1); });
    std::vector<double> powers, irradiances;
    for (const MapSample& s : sample(sky, random, 200000)) {
      powers.push_back(s.radiance[1] / s.pdf);
      irradiances.push_back(s.radiance[1] * std::max(s.wi[1], 0.0) / s.pdf);
    }
    const Mean p = mean_of(powers), e = mean_of(irradiances);
    EXPECT_NEAR(p.mean, power, 4 * p.standard_error + 1e-4 * power) << sky.width() << " x " << sky.height();
    EXPECT_NEAR(e.mean, irradiance, 4 * e.standard_error + 1e-4 * power) << sky.width() << " x " << sky.height();
    EXPECT_LT(p.standard_error, 0.02 * power);
  }
}

TEST(EnvironmentMap, the_mean_of_the_interpolation_over_the_sphere_is_what_selection_counts_with) {
  for (const Sky& sky : skies()) {
    double power = 0;
    for (int c = 0; c < 3; ++c)
      power += integrate(sky, [&](const auto& place, double) { return sky.radiance(place, c); }) / 3;
    EXPECT_NEAR(sky.integral / power, 1, 1e-4) << sky.width() << " x " << sky.height();
  }
}

TEST(EnvironmentMap, L15_a_black_map_has_no_table_and_the_largest_half_a_finite_integral) {
  const Sky black(4, 2, std::vector<glm::vec3>(8, glm::vec3(0)));
  EXPECT_EQ(black.integral, 0);
  EXPECT_TRUE(black.packed.environment_alias_table.empty());
  for (const float4& texel : black.packed.environment_texels) EXPECT_EQ(texel.w, 0);
  const Sky bright(4, 2, one_lit(4, 2, 1, 1, 65504));
  EXPECT_TRUE(std::isfinite(bright.integral) && bright.integral > 0);
}

TEST(EnvironmentMap, what_cannot_be_held_is_refused) {
  PackedScene packed;
  Environment environment;
  auto map = std::make_shared<EnvironmentMap>();
  map->width = 2;
  map->height = 1;
  map->radiance.assign(2, glm::vec3(1e20F));
  environment.map = map;
  environment.scale = 1e20;
  EXPECT_THROW(pack_environment_map(environment, packed), InputError);
}

}  // namespace
}  // namespace eikon::test
