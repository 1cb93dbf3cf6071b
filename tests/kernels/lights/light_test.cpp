// SPDX-License-Identifier: Apache-2.0
// Samples of area lights and of a constant environment: they are uniform, their densities are those
// that rays ask for, and their means those of closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "kernels/lights/alias_table.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

using Vec = std::array<double, 3>;

constexpr std::uint32_t kArea = 0, kEnvironment = 1;  // bits of EK_LIGHT

Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vec& a) { return std::sqrt(dot(a, a)); }

/// Lights of a test, with the densities that packing would give them.
struct Lights {
  std::vector<Light> records;
  LightTable table;
  std::array<float, 4> environment{0, 0, 0, 0};
};

Light triangle_light(const Vec& p0, const Vec& p1, const Vec& p2, float radiance, bool double_sided = false) {
  Light l{};
  l.p0_x = float(p0[0]), l.p0_y = float(p0[1]), l.p0_z = float(p0[2]);
  l.p1_x = float(p1[0]), l.p1_y = float(p1[1]), l.p1_z = float(p1[2]);
  l.p2_x = float(p2[0]), l.p2_y = float(p2[1]), l.p2_z = float(p2[2]);
  l.emission_r = radiance;
  l.emission_g = 0.5F * radiance;
  l.emission_b = 0.25F * radiance;
  l.flags = double_sided ? EK_LIGHT_DOUBLE_SIDED : 0;
  l.kind = kArea;
  return l;
}

Vec corner(const Light& l, int k) {
  if (k == 0) return {l.p0_x, l.p0_y, l.p0_z};
  if (k == 1) return {l.p1_x, l.p1_y, l.p1_z};
  return {l.p2_x, l.p2_y, l.p2_z};
}
Vec normal_of(const Light& l) { return cross(corner(l, 1) - corner(l, 0), corner(l, 2) - corner(l, 0)); }
double area_of(const Light& l) { return 0.5 * length(normal_of(l)); }
double power_of(const Light& l) {
  return std::numbers::pi * area_of(l) * double(l.emission_r) * (l.flags != 0 ? 2 : 1);
}

/// sky: radiance of the environment, chosen as if it had power sky_power; 0: none
Lights with_table(std::vector<Light> records, float sky = 0, double sky_power = 0) {
  Lights lights{.records = std::move(records), .table = {}};
  std::vector<double> powers;
  for (const Light& l : lights.records) powers.push_back(power_of(l));
  if (sky > 0) {
    Light l{};
    l.kind = kEnvironment;
    lights.records.push_back(l);
    powers.push_back(sky_power);
  }
  lights.table = build_light_table(powers);
  for (std::size_t i = 0; i < lights.records.size(); ++i)
    if (lights.records[i].kind == kArea)
      lights.records[i].pdf_m2 = float(lights.table.probability[i] / area_of(lights.records[i]));
  if (sky > 0) lights.environment = {sky, sky, sky, float(lights.table.probability.back())};
  return lights;
}

struct Sample {
  bool environment;
  Vec p, n, radiance, wi, origin, dir;
  double pdf_m2, pdf, t_max, pdf_asked;
};

std::vector<Sample> sample(const Lights& lights, const Words& a, const Words& b, const std::vector<Vec>& p,
                           const Vec& p_error, const Vec& n, bool both_sides = false,
                           const std::string& one_light = "0") {
  std::vector<Words> in{a, b};
  for (std::size_t k = 0; k < 3; ++k) {
    in.emplace_back();
    for (std::size_t i = 0; i < a.size(); ++i) in.back().push_back(as_word(float(p[p.size() == 1 ? 0 : i][k])));
  }
  for (std::size_t k = 0; k < 3; ++k) in.emplace_back(a.size(), as_word(float(p_error[k])));
  for (std::size_t k = 0; k < 3; ++k) in.emplace_back(a.size(), as_word(float(n[k])));
  in.emplace_back(a.size(), both_sides ? 1U : 0U);
  in.insert(in.end(), 2, Words(a.size(), 0U));
  Frame frame{};
  frame.environment = {lights.environment[0], lights.environment[1], lights.environment[2], lights.environment[3]};
  frame.light_count = std::uint32_t(lights.table.buckets.size());
  const auto out = Probe("light")
                       .define("EK_HAS_one_light", one_light)
                       .buffer("lights", lights.records)
                       .buffer("light_alias_table", lights.table.buckets)
                       .buffer("frame", std::vector<Frame>{frame})
                       .buffer("environment_texels", std::vector<float4>(1))
                       .buffer("environment_alias_table", std::vector<AliasEntry>(1))
                       .without_light_paths()
                       .run("probe_light", in, 27);
  std::vector<Sample> samples;
  const auto f = [&](std::size_t k, std::size_t i) { return double(as_float(out[k][i])); };
  const auto vec = [&](std::size_t k, std::size_t i) { return Vec{f(k, i), f(k + 1, i), f(k + 2, i)}; };
  for (std::size_t i = 0; i < a.size(); ++i)
    samples.push_back({.environment = out[0][i] != 0,
                       .p = vec(1, i),
                       .n = vec(4, i),
                       .radiance = vec(7, i),
                       .wi = vec(11, i),
                       .origin = vec(15, i),
                       .dir = vec(18, i),
                       .pdf_m2 = f(10, i),
                       .pdf = f(14, i),
                       .t_max = f(21, i),
                       .pdf_asked = f(22, i)});
  return samples;
}

std::vector<Sample> sample_at(const Lights& lights, std::mt19937& random, std::size_t count, const Vec& p,
                              const Vec& n) {
  const Words a = random_words(random, count), b = random_words(random, count);
  return sample(lights, a, b, {p}, {0, 0, 0}, n);
}

/// Estimates of the irradiance of channel 0 at a surface of normal n.
std::vector<double> irradiance(const std::vector<Sample>& samples, const Vec& n) {
  std::vector<double> estimates;
  for (const Sample& s : samples)
    estimates.push_back(s.pdf > 0 ? s.radiance[0] * std::max(dot(s.wi, n), 0.0) / s.pdf : 0.0);
  return estimates;
}

std::vector<Light> room() {
  std::mt19937 random(6);
  const auto coordinate = [&] { return 4 * double(random()) / 4294967296.0 - 2; };
  std::vector<Light> records;
  for (int i = 0; i < 40; ++i)
    records.push_back(triangle_light({coordinate(), coordinate(), 1 + std::abs(coordinate())},
                                     {coordinate(), coordinate(), 1 + std::abs(coordinate())},
                                     {coordinate(), coordinate(), 1 + std::abs(coordinate())}, float(0.1 + i * i),
                                     i % 3 == 0));
  return records;
}

TEST(Light, sampled_power_of_emissive_triangles_is_that_of_the_closed_form) {
  const Lights lights = with_table(room());
  double power = 0;
  for (const Light& l : lights.records) power += power_of(l);
  std::mt19937 random(7);
  std::vector<double> estimates;
  // A point of a light radiates L pi per area and side.
  for (const Sample& s : sample_at(lights, random, 500000, {0, 0, 0}, {0, 0, 1})) {
    const auto light = std::find_if(lights.records.begin(), lights.records.end(),
                                    [&](const Light& l) { return double(l.emission_r) == s.radiance[0]; });
    ASSERT_NE(light, lights.records.end());
    ASSERT_EQ(s.radiance[1], double(light->emission_g));
    ASSERT_EQ(s.radiance[2], double(light->emission_b));
    estimates.push_back(std::numbers::pi * s.radiance[0] * (light->flags != 0 ? 2 : 1) / s.pdf_m2);
  }
  const Mean mean = mean_of(estimates);
  EXPECT_NEAR(mean.mean, power, 4 * mean.standard_error + 1e-6 * power);
  EXPECT_LT(mean.standard_error, 1e-2 * power) << "choosing by power leaves little to vary";
}

TEST(Light, M1_points_are_uniform_over_each_light_and_lie_on_it) {
  constexpr unsigned kGrid = 8;
  const Lights lights = with_table(room());
  std::mt19937 random(8);
  constexpr std::size_t kSamples = 500000;
  std::vector<double> observed(lights.records.size() * kGrid * kGrid, 0), expected;
  for (const double p : lights.table.probability)
    expected.insert(expected.end(), kGrid * kGrid, p * kSamples / (kGrid * kGrid));
  for (const Sample& s : sample_at(lights, random, kSamples, {0, 0, 0}, {0, 0, 1})) {
    const auto light = std::size_t(std::find_if(lights.records.begin(), lights.records.end(),
                                                [&](const Light& l) { return double(l.emission_r) == s.radiance[0]; }) -
                                   lights.records.begin());
    const Light& l = lights.records[light];
    const Vec n = normal_of(l), q = s.p - corner(l, 0);
    ASSERT_LT(std::abs(dot(n, q)) / length(n), 2e-6);
    const double b1 = dot(cross(q, corner(l, 2) - corner(l, 0)), n) / dot(n, n);
    const double b2 = dot(cross(corner(l, 1) - corner(l, 0), q), n) / dot(n, n);
    ASSERT_TRUE(b1 > -1e-5 && b2 > -1e-5 && b1 + b2 < 1 + 1e-5);
    const double sum = std::clamp(b1 + b2, 0.0, 1.0), share = sum > 0 ? std::clamp(b2 / sum, 0.0, 1.0) : 0;
    const auto row = std::min(unsigned(sum * sum * kGrid), kGrid - 1),
               column = std::min(unsigned(share * kGrid), kGrid - 1);
    ++observed[(light * kGrid + row) * kGrid + column];
  }
  const ChiSquare test = chi_square(observed, expected);
  EXPECT_GT(test.p_value, kSignificance) << test.table;
}

TEST(Light, density_per_solid_angle_is_what_a_ray_to_the_same_point_asks_for) {
  std::mt19937 random(9);
  const Lights lights = with_table(room(), 2.0F, 500.0);
  std::size_t seen = 0;
  for (const Sample& s : sample_at(lights, random, 100000, {0.1, -0.3, 0}, {0, 0, 1})) {
    if (s.pdf == 0) continue;
    ++seen;
    ASSERT_NEAR(s.pdf, s.pdf_asked, 2e-6 * s.pdf) << (s.environment ? "environment" : "triangle");
    if (s.environment) continue;
    const Vec d = s.p - Vec{double(0.1F), double(-0.3F), 0};
    const double r2 = dot(d, d), cosine = std::abs(dot(s.n, d)) / std::sqrt(r2);
    ASSERT_NEAR(s.pdf, s.pdf_m2 * r2 / cosine, 1e-4 * s.pdf + 1e-5 * s.pdf / cosine);
  }
  EXPECT_GT(seen, 50000U);
}

TEST(Light, L1_irradiance_below_a_unit_square_is_that_of_the_closed_form) {
  const Vec a{-0.5, -0.5, 1}, b{-0.5, 0.5, 1}, c{0.5, 0.5, 1}, d{0.5, -0.5, 1};  // clockwise from above: faces down
  const Lights lights = with_table({triangle_light(a, b, c, 1), triangle_light(a, c, d, 1)});
  std::mt19937 random(10);
  const Mean E = mean_of(irradiance(sample_at(lights, random, 1000000, {0, 0, 0}, {0, 0, 1}), {0, 0, 1}));
  EXPECT_NEAR(E.mean, 0.752274688, 4 * E.standard_error);
  EXPECT_LT(E.standard_error, 5e-4);
}

TEST(Light, L1_two_triangles_as_one_parallelogram_are_sampled_evenly_all_over) {
  Light square = triangle_light({-0.5, 0.5, 1}, {0.5, 0.5, 1}, {-0.5, -0.5, 1}, 1);  // faces down
  square.flags = EK_LIGHT_QUAD;
  Lights lights = with_table({square});
  lights.records[0].pdf_m2 *= 0.5F;
  std::mt19937 random(17);
  const auto samples = sample_at(lights, random, 500000, {0, 0, 0}, {0, 0, 1});
  const Mean E = mean_of(irradiance(samples, {0, 0, 1}));
  EXPECT_NEAR(E.mean, 0.752274688, 4 * E.standard_error);
  std::vector<double> cells(64, 0);
  for (const Sample& s : samples) {
    ASSERT_LE(std::abs(s.p[0]), 0.5);
    ASSERT_LE(std::abs(s.p[1]), 0.5);
    ++cells[std::size_t(std::min((s.p[0] + 0.5) * 8, 7.0)) * 8 + std::size_t(std::min((s.p[1] + 0.5) * 8, 7.0))];
  }
  EXPECT_GT(chi_square(cells, std::vector<double>(64, double(samples.size()) / 64)).p_value, kSignificance);
}

// Without a choice the same words give the same sample, to the bit, but for the last word: a full
// bucket gives that to its alias.
TEST(Light, an_only_light_is_sampled_as_if_it_had_been_chosen) {
  const Lights lights = with_table({triangle_light({0, 0, 1}, {0, 1, 1}, {1, 0, 1}, 1)});
  std::mt19937 random(18);
  Words a = random_words(random, 4096), b = random_words(random, 4096);
  a[0] = 0, a[1] = 0xfffffffeU, b[0] = 0xffffffffU;
  const auto chosen = sample(lights, a, b, {{0, 0, 0}}, {0, 0, 0}, {0, 0, 1});
  const auto only = sample(lights, a, b, {{0, 0, 0}}, {0, 0, 0}, {0, 0, 1}, false, "1");
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(chosen[i].p, only[i].p);
    ASSERT_EQ(chosen[i].pdf, only[i].pdf);
    ASSERT_EQ(chosen[i].radiance, only[i].radiance);
  }
}

TEST(Light, L13_a_constant_environment_gives_the_same_irradiance_from_every_sample) {
  const Lights lights = with_table({}, 3.0F, 1.0);
  std::mt19937 random(11);
  const double diagonal = 1 / std::sqrt(3.0);
  const Vec n{diagonal, -diagonal, diagonal};
  for (const double estimate : irradiance(sample_at(lights, random, 100000, {5, 6, 7}, n), n))
    ASSERT_NEAR(estimate, 3 * std::numbers::pi, 3 * std::numbers::pi * 2e-3) << "grazing directions lose digits";
}

TEST(Light, where_light_from_below_counts_the_environment_is_sampled_on_both_sides) {
  const Lights lights = with_table({}, 3.0F, 1.0);
  std::mt19937 random(16);
  const Words a = random_words(random, 100000), b = random_words(random, 100000);
  std::size_t below = 0;
  for (const Sample& s : sample(lights, a, b, {{0, 0, 0}}, {0, 0, 0}, {0, 0, 1}, true)) {
    below += s.wi[2] < 0 ? 1 : 0;
    ASSERT_NEAR(s.radiance[0] * std::abs(s.wi[2]) / s.pdf, 6 * std::numbers::pi, 6 * std::numbers::pi * 2e-3);
    ASSERT_NEAR(s.pdf, s.pdf_asked, 2e-6 * s.pdf);
  }
  EXPECT_NEAR(double(below), 50000, 4 * std::sqrt(25000.0));
}

TEST(Light, triangles_and_environment_together_give_the_sum_of_each) {
  const Vec a{-0.5, -0.5, 1}, b{-0.5, 0.5, 1}, c{0.5, 0.5, 1}, d{0.5, -0.5, 1};
  std::mt19937 random(12);
  for (const double sky_power : {0.01, 1.0, 100.0}) {
    const Lights lights = with_table({triangle_light(a, b, c, 1), triangle_light(a, c, d, 1)}, 0.5F, sky_power);
    const Mean E = mean_of(irradiance(sample_at(lights, random, 1000000, {0, 0, 0}, {0, 0, 1}), {0, 0, 1}));
    EXPECT_NEAR(E.mean, 0.752274688 + 0.5 * std::numbers::pi, 4 * E.standard_error) << sky_power;
  }
}

TEST(Light, L16_the_mean_is_the_sum_over_lights_however_their_powers_differ) {
  std::mt19937 random(13);
  std::vector<Light> records;
  for (int i = 0; i < 100000; ++i) {
    const double x = double(random()) / 4294967296.0 * 10 - 5, y = double(random()) / 4294967296.0 * 10 - 5;
    const float radiance = i % 7 == 0 ? 0.0F : float(std::pow(10.0, double(random()) / 4294967296.0 * 20 - 10));
    records.push_back(triangle_light({x, y, 2}, {x, y + 0.1, 2}, {x + 0.1, y, 2}, radiance));
  }
  const Lights lights = with_table(records);
  double exact = 0;  // small and far: one point each is close enough
  for (const Light& l : lights.records) {
    const Vec centre{double(l.p0_x) + 0.1 / 3, double(l.p0_y) + 0.1 / 3, 2};
    const double r2 = dot(centre, centre);
    exact += double(l.emission_r) * area_of(l) * 4 / (r2 * r2);
  }
  const auto samples = sample_at(lights, random, 1000000, {0, 0, 0}, {0, 0, 1});
  for (const Sample& s : samples) {
    ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0);
    ASSERT_GT(s.radiance[0], 0);
  }
  const Mean E = mean_of(irradiance(samples, {0, 0, 1}));
  EXPECT_NEAR(E.mean, exact, 4 * E.standard_error + 1e-3 * exact);
}

TEST(Light, only_the_front_emits_unless_double_sided_and_an_edge_gives_nothing) {
  std::mt19937 random(14);
  for (const bool double_sided : {false, true}) {
    const Lights lights = with_table({triangle_light({0, 0, 1}, {0, 1, 1}, {1, 0, 1}, 1, double_sided)});  // faces down
    for (const Sample& s : sample_at(lights, random, 1000, {0, 0, 0}, {0, 0, 1})) ASSERT_GT(s.pdf, 0) << "front";
    for (const Sample& s : sample_at(lights, random, 1000, {0, 0, 2}, {0, 0, -1}))
      ASSERT_EQ(s.pdf > 0, double_sided) << "back";
    const Lights flat = with_table({triangle_light({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 1, double_sided)});
    for (const Sample& s : sample_at(flat, random, 1000, {3, 3, 0}, {-1, 0, 0})) ASSERT_EQ(s.pdf, 0) << "edge on";
  }
}

TEST(Light, N2_the_ends_of_the_word_range_are_samples_like_any_other) {
  const Lights lights = with_table(room(), 2.0F, 500.0);
  const Words ends{0, 0xffffffffU, 0, 0xffffffffU}, others{0, 0, 0xffffffffU, 0xffffffffU};
  for (const Sample& s : sample(lights, ends, others, {{0, 0, -1}}, {0, 0, 0}, {0, 0, 1})) {
    EXPECT_TRUE(std::isfinite(s.pdf) && std::isfinite(s.radiance[0]) && s.pdf_m2 > 0);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(s.p[k]) && std::isfinite(s.wi[k]));
  }
  const Lights sky = with_table({}, 1.0F, 1.0);
  for (const Sample& s : sample(sky, ends, others, {{0, 0, 0}}, {0, 0, 0}, {0, 0, 1})) EXPECT_GT(s.pdf, 0);
}

// A shadow ray must end just before the light that it goes to, at any scale and distance.
TEST(Light, G3_shadow_rays_stop_just_short_of_their_light) {
  std::mt19937 random(15);
  const auto unit = [&] { return 2 * double(random()) / 4294967296.0 - 1; };
  for (const double scale : {1e-6, 1.0, 1e6})
    for (const double distance : {0.01, 1.0, 1000.0})
      for (const double offset : {0.0, 1e3}) {  // of everything from the origin
        std::vector<Light> records;
        for (int i = 0; i < 64; ++i) {
          const auto point = [&] {
            return Vec{scale * (unit() + offset), scale * (unit() + offset), scale * (unit() + offset)};
          };
          records.push_back(triangle_light(point(), point(), point(), 1, true));
        }
        const Lights lights = with_table(records);
        const std::size_t count = 50000;
        std::vector<Vec> points;
        for (std::size_t i = 0; i < count; ++i) {
          Vec p{};
          for (double& x : p) x = double(float(scale * (unit() * distance + offset)));
          points.push_back(p);
        }
        const Words a = random_words(random, count), b = random_words(random, count);
        const Vec error{1e-7 * scale, 1e-7 * scale, 1e-7 * scale};
        const auto samples = sample(lights, a, b, points, error, {0, 0, 1});
        std::size_t beyond = 0, tested = 0, short_of = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const Sample& s = samples[i];
          const Light& l = lights.records[choose(lights.table, a[i])];
          const Vec n = normal_of(l);
          const double cosine = std::abs(dot(n, s.dir)) / length(n) / length(s.dir);
          // Nothing is promised nearly along the light, or as near as coordinates are rounded.
          if (s.pdf == 0 || cosine < 0.01 || length(s.dir) < 1e-4 * scale * (1 + offset)) continue;
          ++tested;
          const double t_plane = dot(n, corner(l, 0) - s.origin) / dot(n, s.dir);
          beyond += t_plane <= s.t_max ? 1 : 0;
          short_of += t_plane > 1.01 + 1e-4 * (1 + offset) * scale / length(s.dir) / cosine ? 1 : 0;
        }
        EXPECT_GT(tested, count / 2);
        EXPECT_EQ(beyond, 0U) << "scale " << scale << ", distance " << distance << ", offset " << offset;
        EXPECT_EQ(short_of, 0U) << "scale " << scale << ", distance " << distance << ", offset " << offset;
      }
}

TEST(Light, M8_power_heuristic_weights_are_finite_and_add_to_one_for_any_densities) {
  const float infinity = INFINITY;
  const std::vector<float> densities{0, 1e-30F, 1e-3F, 1, 3, 1e10F, 1.9e19F, 1e30F, 3e38F, infinity};
  std::vector<float> a, b;
  for (const float x : densities)
    for (const float y : densities) {
      a.push_back(x);
      b.push_back(y);
    }
  const Words there = Probe("light").run("probe_power_heuristic", {as_words(a), as_words(b)}, 1)[0];
  const Words back = Probe("light").run("probe_power_heuristic", {as_words(b), as_words(a)}, 1)[0];
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float weight = as_float(there[i]), other = as_float(back[i]);
    ASSERT_TRUE(weight >= 0 && weight <= 1) << a[i] << ", " << b[i] << ": " << weight;
    ASSERT_NEAR(weight + other, 1, 2e-7) << a[i] << ", " << b[i];
    if (a[i] > 0 && std::isfinite(a[i]) && std::isfinite(b[i])) {
      const long double ratio = static_cast<long double>(b[i]) / static_cast<long double>(a[i]);
      ASSERT_NEAR(weight, double(1 / (1 + ratio * ratio)), 3e-7) << a[i] << ", " << b[i];
    }
  }
}

}  // namespace
}  // namespace eikon::test
