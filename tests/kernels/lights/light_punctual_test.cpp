// SPDX-License-Identifier: Apache-2.0
// Point, spot and directional lights [KHR_lights_punctual], from the scene to what arrives.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kernels/probe.h"
#include "instruments/analytic_scenes.h"
#include "pack/frame.h"
#include "pack/pack.h"

namespace eikon::test {
namespace {

using std::numbers::pi;

PunctualLight light_of(LightKind kind, float intensity) {
  PunctualLight light;
  light.name = "lamp";
  light.kind = kind;
  light.intensity = glm::vec3(intensity, 0.5F * intensity, 0);
  light.direction = {0, 0, -1};
  return light;
}

PunctualLight spot_of(double inner_deg, double outer_deg) {
  PunctualLight light = light_of(LightKind::spot, 3);
  light.inner_cone_rad = inner_deg * pi / 180;
  light.outer_cone_rad = outer_deg * pi / 180;
  return light;
}

PackedScene packed_with(const std::vector<PunctualLight>& lights) {
  Scene scene;
  Primitive quad;
  add_quad(quad, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "floor", std::move(quad), lambert(1));
  scene.lights = lights;
  const Settings settings = settings_for(1, 1, 1);
  return pack_in_world(scene, Features(scene, settings), settings);
}

struct Arrival {
  double r, g, b, pdf, t_max;
  glm::dvec3 wi, dir;
  bool delta;
};

/// What arrives of the only light at each point.
std::vector<Arrival> arrivals(const PunctualLight& light, const std::vector<glm::dvec3>& points) {
  const PackedScene packed = packed_with({light});
  Frame frame{};
  frame.light_count = std::uint32_t(packed.light_alias_table.size());
  std::vector<Words> in(14, Words(points.size(), 0x12345678U));
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      in[std::size_t(2 + k)][i] = as_word(float(points[i][k]));
      in[std::size_t(5 + k)][i] = 0;
      in[std::size_t(8 + k)][i] = as_word(k == 2 ? 1.0F : 0.0F);
    }
  const auto out = Probe("light")
                       .buffer("frame", std::vector<Frame>{frame})
                       .buffer("lights", packed.lights)
                       .buffer("light_alias_table", packed.light_alias_table)
                       .buffer("environment_texels", std::vector<float4>(1))
                       .buffer("environment_alias_table", std::vector<AliasEntry>(1))
                       .without_light_paths()
                       .run("probe_light", in, 27);
  std::vector<Arrival> list;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto f = [&](std::size_t k) { return double(as_float(out[k][i])); };
    list.push_back({.r = f(23),
                    .g = f(24),
                    .b = f(25),
                    .pdf = f(14),
                    .t_max = f(21),
                    .wi = {f(11), f(12), f(13)},
                    .dir = {f(18), f(19), f(20)},
                    .delta = out[26][i] == 1});
  }
  return list;
}

/// At the distance and angle from the -Z axis of a light at the origin.
glm::dvec3 off_axis(double distance, double degrees) {
  return distance * glm::dvec3(std::sin(degrees * pi / 180), 0, -std::cos(degrees * pi / 180));
}

TEST(LightPunctual, points_fall_off_with_the_square_all_around_and_shadow_rays_end_at_them) {
  PunctualLight light = light_of(LightKind::point, 3);
  light.position = {1, 2, 3};
  const std::vector<glm::dvec3> points{{1, 2, 2}, {1, 2, 5}, {4, 6, 3}, {1, 2 + 1e-3, 3}, {1001, 2, 3}};
  const double distances[] = {1, 2, 5, 1e-3, 1000};
  const auto list = arrivals(light, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double expected = 3 / (distances[i] * distances[i]);
    EXPECT_NEAR(list[i].r / expected, 1, i == 3 ? 5e-4 : 1e-6) << "nearby, coordinates round";
    EXPECT_NEAR(list[i].g / expected, 0.5, 5e-4);
    EXPECT_EQ(list[i].b, 0);
    EXPECT_EQ(list[i].pdf, 1);
    EXPECT_TRUE(list[i].delta);
    EXPECT_LT(glm::length(list[i].wi - glm::normalize(light.position - points[i])), 1e-4);
    EXPECT_LT(glm::length(points[i] + list[i].dir - light.position), 1e-3 * distances[i]);
    EXPECT_TRUE(list[i].t_max < 1 && list[i].t_max > 0.9999);
  }
}

TEST(LightPunctual, L18_range_ends_light_smoothly) {
  for (const double range : {2.0, 7.0, 0.3}) {
    PunctualLight light = light_of(LightKind::point, 1);
    light.range_m = range;
    const auto list =
        arrivals(light, {off_axis(range, 0), off_axis(range / 2, 0), off_axis(2 * range, 0), off_axis(0, 0)});
    EXPECT_NEAR(list[0].r * range * range, 0, 1e-6);
    EXPECT_NEAR(list[1].r * range * range / 4, 1 - 1.0 / 16, 1e-6);
    EXPECT_EQ(list[2].r, 0);
    EXPECT_EQ(list[3].pdf, 0) << "at the light nothing arrives, and nothing infinite";
  }
  EXPECT_EQ(arrivals(light_of(LightKind::point, 1), {off_axis(1024, 30)})[0].r, 0x1p-20) << "no range";
}

TEST(LightPunctual, L17_a_spot_fades_between_its_cones_and_gives_nothing_outside) {
  const std::vector<glm::dvec3> points{off_axis(2, 22.5), off_axis(2, 45), off_axis(2, 0), off_axis(2, 60),
                                       off_axis(2, 180)};
  const auto soft = arrivals(spot_of(0, 45), points);
  EXPECT_NEAR(soft[0].r, 0.547761 * 3 / 4, 2e-6);
  EXPECT_NEAR(soft[1].r, 0, 1e-9);
  EXPECT_NEAR(soft[2].r, 3.0 / 4, 1e-6);
  EXPECT_EQ(soft[3].r, 0);
  EXPECT_EQ(soft[4].r, 0);
  const auto step =
      arrivals(spot_of(30, 30), {off_axis(2, 29.5), off_axis(2, 30.5), off_axis(2, 29.99), off_axis(2, 0)});
  EXPECT_NEAR(step[0].r, 3.0 / 4, 1e-6);
  EXPECT_EQ(step[1].r, 0);
  EXPECT_TRUE(std::isfinite(step[2].r) && step[2].r >= 0 && step[2].r < 3.0 / 4);
  EXPECT_NEAR(step[3].r, 3.0 / 4, 1e-6);
}

TEST(LightPunctual, a_spot_keeps_its_cone_where_its_node_turns_it) {
  PunctualLight light = spot_of(10, 20);
  light.position = {1, 1, 1};
  light.direction = glm::normalize(glm::dvec3(1, -2, 0.5));
  const glm::dvec3 aside = glm::normalize(glm::cross(light.direction, glm::dvec3(0, 1, 0)));
  const auto at = [&](double degrees) {
    return light.position +
           4.0 * (std::cos(degrees * pi / 180) * light.direction + std::sin(degrees * pi / 180) * aside);
  };
  const auto list = arrivals(light, {at(0), at(9.5), at(20.5), at(15)});
  EXPECT_NEAR(list[0].r, 3.0 / 16, 1e-6);
  EXPECT_NEAR(list[1].r, 3.0 / 16, 1e-6);
  EXPECT_EQ(list[2].r, 0);
  const double c = [](double d) { return std::cos(d * pi / 180); }(15), ci = std::cos(10 * pi / 180),
               co = std::cos(20 * pi / 180);
  EXPECT_NEAR(list[3].r, 3.0 / 16 * std::pow((c - co) / (ci - co), 2), 1e-5);
}

TEST(LightPunctual, directional_light_arrives_the_same_everywhere_from_infinitely_far) {
  PunctualLight light = light_of(LightKind::directional, 1e5F);  // L19: a sun of 100 klx
  light.direction = glm::normalize(glm::dvec3(0.3, -0.2, -0.9));
  for (const Arrival& a : arrivals(light, {{0, 0, 0}, {1e6, -1e6, 3}, {0, 0, -1e-6}})) {
    EXPECT_EQ(a.r, 1e5);
    EXPECT_EQ(a.g, 5e4);
    EXPECT_LT(glm::length(a.wi + light.direction), 1e-7);
    EXPECT_TRUE(std::isinf(a.t_max) && a.delta && a.pdf == 1);
  }
}

TEST(LightPunctual, flux_is_the_integral_of_what_arrives_and_a_lamp_of_815_lumens_has_64_86_candela) {
  PunctualLight bulb = light_of(LightKind::point, 1);
  bulb.intensity = glm::vec3(64.86F);
  const PackedScene packed = packed_with({bulb});
  ASSERT_EQ(packed.light_summary.size(), 1U);
  EXPECT_NEAR(packed.light_summary[0].flux, 815, 0.1);
  EXPECT_EQ(packed.light_summary[0].kind, LightKind::point);
  EXPECT_EQ(packed.light_summary[0].name, "lamp");
  for (const auto& [inner, outer] : {std::pair(0.0, 45.0), {30.0, 30.0}, {20.0, 60.0}, {0.0, 1.0}, {0.0, 90.0}}) {
    std::vector<glm::dvec3> points;
    constexpr int kSteps = 4096;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = 1 - (i + 0.5) / kSteps * (1 - std::cos(1.01 * outer * pi / 180));
      points.emplace_back(std::sqrt(1 - cosine * cosine), 0, -cosine);
    }
    double flux = 0;
    for (const Arrival& a : arrivals(spot_of(inner, outer), points))
      flux += (a.r + a.g + a.b) / 3 * 2 * pi * (1 - std::cos(1.01 * outer * pi / 180)) / kSteps;
    EXPECT_NEAR(packed_with({spot_of(inner, outer)}).light_summary[0].flux / flux, 1, 2e-3) << inner << ", " << outer;
  }
}

TEST(LightPunctual, L16_probabilities_add_to_one_and_an_absurd_light_does_not_starve_the_others) {
  std::vector<PunctualLight> lights{light_of(LightKind::point, 1),
                                    light_of(LightKind::directional, 2), spot_of(10, 20),
                                    light_of(LightKind::point, 0)};
  double sum = 0;
  const PackedScene even = packed_with(lights);
  ASSERT_EQ(even.light_summary.size(), 3U) << "one gives no light";
  for (const PackedLight& light : even.light_summary) sum += light.probability;
  EXPECT_EQ(sum, 1);
  // The quad's bounding sphere has the radius sqrt 2: the sun's flux is E pi 2.
  EXPECT_NEAR(even.light_summary[1].flux, 1.0 * 2 * pi, 1e-6);
  lights.push_back(light_of(LightKind::directional, 3e38F));
  for (const PackedLight& light : packed_with(lights).light_summary) {
    EXPECT_GE(light.probability, 0x1p-11);
    EXPECT_TRUE(std::isfinite(light.flux));
  }
}

}  // namespace
}  // namespace eikon::test
