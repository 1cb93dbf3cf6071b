// SPDX-License-Identifier: Apache-2.0
// Hard cases of geometry, on the production traversal kernels.
#include <gtest/gtest.h>

#include <cstring>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using fixtures::Soup;
using Point = std::array<float, 3>;

/// Every layout and accelerator; those that trace small trees as packets, without them too.
std::vector<TraverseProbe::Options> ways() {
  std::vector<TraverseProbe::Options> all;
  for (const std::string& layout : every_layout()) {
    TraverseProbe::Options options;
    options.layout = layout;
    all.push_back(options);
    options.defines = {{"EK_SMALL_TREE", "0"}};
    if (layout == "bvh16" || layout == "bvh8") all.push_back(options);
  }
  for (const std::string& name : accelerator_names()) {
    all.emplace_back();
    all.back().layout = "bvh2";
    all.back().method = name;
  }
  return all;
}
const std::vector<TraverseProbe::Options> kWays = ways();

/// A closed sphere, 16 x 16, each vertex at its own radius in [1, 6]; and rays from near its
/// centre, at random and straight at vertices and midpoints of edges.
struct BumpySphere {
  Soup soup;
  std::vector<ProbeRay> rays;
  explicit BumpySphere(const double (&center)[3], std::uint32_t seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    std::vector<float> radii(9 * 16);
    for (float& r : radii) r = 3.5F + 2.5F * unit(random);
    soup = fixtures::sphere(
        8, [&](int i, int j) { return radii[static_cast<std::size_t>(16 * i + j)]; }, center);
    const auto origin = [&] {
      Point o{};
      for (std::size_t k = 0; k < 3; ++k) o[k] = static_cast<float>(center[k]) + 0.2F * unit(random);
      return o;
    };
    for (int i = 0; i < 100'000; ++i) {
      ProbeRay ray;
      ray.o = origin();
      for (float& d : ray.d) d = unit(random);
      rays.push_back(ray);
    }
    for (std::size_t i = 0; i < soup.size(); i += 9) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        for (const float weight : {0.0F, 0.5F}) {
          const float *p = &soup[i + 3 * corner], *q = &soup[i + 3 * ((corner + 1) % 3)];
          ProbeRay ray;
          ray.o = origin();
          for (std::size_t k = 0; k < 3; ++k) ray.d[k] = p[k] + weight * (q[k] - p[k]) - ray.o[k];
          rays.push_back(ray);
        }
      }
    }
  }
};

std::size_t misses(const std::vector<ProbeHit>& hits) {
  return static_cast<std::size_t>(
      std::count_if(hits.begin(), hits.end(), [](const ProbeHit& h) { return h.triangle == EK_NO_HIT; }));
}

TEST(TraverseHard, G1_no_ray_leaves_a_closed_bumpy_sphere) {
  Device& device = *test::devices().front();
  const BumpySphere scene({0, 0, 0});
  for (const TraverseProbe::Options& way : kWays) {
    TraverseProbe probe(device, scene.soup, way);
    EXPECT_EQ(misses(probe.closest(scene.rays)), 0U) << TraverseProbe::describe(way);
    const auto blocked = probe.any(scene.rays);
    EXPECT_TRUE(std::all_of(blocked.begin(), blocked.end(), [](bool b) { return b; })) << TraverseProbe::describe(way);
  }
}

TEST(TraverseHard, G2_no_ray_leaves_a_closed_bumpy_sphere_far_from_the_origin) {
  Device& device = *test::devices().front();
  const BumpySphere scene({148376, 1234, -223423});
  for (const TraverseProbe::Options& way : kWays) {
    TraverseProbe probe(device, scene.soup, way);
    EXPECT_EQ(misses(probe.closest(scene.rays)), 0U) << TraverseProbe::describe(way);
  }
}

TEST(TraverseHard, G9_a_scene_times_a_power_of_two_gives_scaled_hits_to_the_bit) {
  Device& device = *test::devices().front();
  const Soup soup = fixtures::scattered(500, 1.0F, 21);
  std::mt19937 random(22);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(5000);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (float& x : rays[i].o) x = 1.5F * unit(random);
    for (float& x : rays[i].d) x = unit(random);
    if (i % 3 == 0) rays[i].d[i % 7 % 3] = 0;
    if (i % 5 == 0) std::copy_n(&soup[9 * (i % 500)], 3, rays[i].o.begin());  // from a vertex
  }
  for (const TraverseProbe::Options& way : kWays) {
    const auto expected = TraverseProbe(device, soup, way).closest(rays);
    for (const int k : {-20, -1, 7, 20}) {
      Soup scaled = soup;
      for (float& x : scaled) x = std::ldexp(x, k);
      auto camera = rays, shadow = rays;  // directions stay unit, or span the distance to a light
      for (auto& ray : camera) {
        for (float& x : ray.o) x = std::ldexp(x, k);
      }
      shadow = camera;
      for (auto& ray : shadow) {
        for (float& x : ray.d) x = std::ldexp(x, k);
      }
      TraverseProbe probe(device, scaled, way);
      const auto far = probe.closest(camera), segment = probe.closest(shadow);
      std::size_t different = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ProbeHit hit = expected[i];
        different += std::memcmp(&segment[i], &hit, sizeof hit) != 0 ? 1 : 0;
        hit.t = std::ldexp(hit.t, k);
        different += std::memcmp(&far[i], &hit, sizeof hit) != 0 ? 1 : 0;
      }
      EXPECT_EQ(different, 0U) << TraverseProbe::describe(way) << " 2^" << k;
    }
  }
}

TEST(TraverseHard, G10_zero_components_hit_what_the_limit_ray_hits) {
  Device& device = *test::devices().front();
  // A wall of unit quads at z = 0; rays start on planes and corners of the boxes of its tree.
  Soup soup;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      const float a[3] = {float(x), float(y), 0}, b[3] = {float(x + 1), float(y), 0},
                  c[3] = {float(x + 1), float(y + 1), 0}, d[3] = {float(x), float(y + 1), 0};
      fixtures::add_triangle(soup, a, b, c);
      fixtures::add_triangle(soup, a, c, d);
    }
  }
  std::vector<ProbeRay> positive, negative, limit;
  for (int x = 0; x <= 16; ++x) {
    for (int y = 0; y <= 16; ++y) {
      for (const float side : {1.0F, -1.0F}) {
        ProbeRay ray;
        ray.o = {0.5F * static_cast<float>(x), 0.5F * static_cast<float>(y), side};
        ray.d = {0.0F, 0.0F, -side};
        positive.push_back(ray);
        ray.d = {-0.0F, -0.0F, -side};
        negative.push_back(ray);
        ray.d = {x < 8 ? 1e-30F : -1e-30F, y < 8 ? 1e-30F : -1e-30F, -side};  // not off the wall's border
        limit.push_back(ray);
      }
    }
  }
  for (const TraverseProbe::Options& way : kWays) {
    TraverseProbe probe(device, soup, way);
    const auto expected = probe.closest(positive);
    EXPECT_EQ(misses(expected), 0U) << TraverseProbe::describe(way);
    const auto other_zero = probe.closest(negative), near_limit = probe.closest(limit);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(expected[i].t, 1.0F) << TraverseProbe::describe(way) << ' ' << i;
      EXPECT_EQ(std::memcmp(&other_zero[i], &expected[i], sizeof expected[i]), 0)
          << TraverseProbe::describe(way) << ' ' << i;
      EXPECT_EQ(near_limit[i].t, 1.0F) << TraverseProbe::describe(way) << ' '
                                       << i;  // on an edge the triangle may be its neighbour
    }
  }
}

TEST(TraverseHard, G10_rays_within_the_plane_of_a_wall_end_and_report_finite_hits) {
  Device& device = *test::devices().front();
  Soup soup;
  for (int x = 0; x < 20; ++x) {
    const auto f = static_cast<float>(x);
    fixtures::add_triangle(soup, {f, 0, 0}, {f + 1, 0, 0}, {f, 1, 0});
  }
  std::vector<ProbeRay> rays;
  for (const float zero : {0.0F, -0.0F}) {
    for (const float y : {0.0F, 0.5F, 1.0F, -1.0F}) {
      ProbeRay ray;
      ray.o = {-3, y, zero};
      ray.d = {1, zero, zero};
      rays.push_back(ray);
    }
  }
  for (const TraverseProbe::Options& way : kWays) {
    TraverseProbe probe(device, soup, way);
    for (const ProbeHit& hit : probe.closest(rays))
      EXPECT_FALSE(std::isnan(hit.t) || std::isnan(hit.u) || std::isnan(hit.v));
  }
}

// A ray without numbers would be within every box, even those of children that are missing: at the
// root again, for ever.
TEST(TraverseHard, G10_rays_that_are_none_end_hit_nothing_and_change_no_others) {
  Device& device = *test::devices().front();
  const Soup soup = fixtures::bumpy_sphere(7);
  std::vector<ProbeRay> rays;
  std::mt19937 random(77);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (int i = 0; i < 30; ++i) {
    ProbeRay ray;
    for (std::size_t k = 0; k < 3; ++k) ray.o[k] = 0.2F * unit(random), ray.d[k] = unit(random);
    rays.push_back(ray);
    const std::vector<ProbeRay> none = rays_that_are_none(ray);
    rays.insert(rays.end(), none.begin(), none.end());
  }
  const std::size_t each = rays.size() / 30;
  for (const TraverseProbe::Options& way : TraverseProbe::variants()) {
    if (way.method != "bvh" && way.width != 1) continue;  // one ray at a time at any width
    TraverseProbe probe(device, soup, way);
    const std::vector<ProbeHit> hits = probe.closest(rays);
    const std::vector<bool> blocked = probe.any(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(hits[i].triangle == EK_NO_HIT, i % each != 0) << TraverseProbe::describe(way) << ": ray " << i % each;
      EXPECT_EQ(blocked[i], i % each == 0) << TraverseProbe::describe(way) << ": ray " << i % each;
    }
  }
}

TEST(TraverseHard, G11_degenerate_triangles_are_never_hit_and_change_nothing) {
  Device& device = *test::devices().front();
  const Soup clean = fixtures::bumpy_sphere(10);
  Soup dirty = clean;
  std::vector<ProbeRay> rays;
  std::mt19937 random(31);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (std::size_t i = 0; i < clean.size(); i += 27) {
    Soup p(clean.begin() + static_cast<std::ptrdiff_t>(i), clean.begin() + static_cast<std::ptrdiff_t>(i) + 9);
    std::copy_n(p.begin(), 3, p.begin() + 3);  // repeated corner
    dirty.insert(dirty.end(), p.begin(), p.end());
    for (std::size_t k = 0; k < 3; ++k) {  // collinear, exactly
      p[3 + k] = 2 * p[k];
      p[6 + k] = 0.5F * p[k];
    }
    dirty.insert(dirty.end(), p.begin(), p.end());
    ProbeRay ray;  // through the collinear one
    ray.o = {2 * unit(random), 2 * unit(random), 2 * unit(random)};
    for (std::size_t k = 0; k < 3; ++k) ray.d[k] = 0.7F * p[k] - ray.o[k];
    rays.push_back(ray);
  }
  for (const TraverseProbe::Options& way : kWays) {
    const auto expected = TraverseProbe(device, clean, way).closest(rays);
    const auto hits = TraverseProbe(device, dirty, way).closest(rays);
    for (std::size_t i = 0; i < rays.size(); ++i)
      EXPECT_EQ(std::memcmp(&hits[i], &expected[i], sizeof hits[i]), 0) << TraverseProbe::describe(way);
  }
}

TEST(TraverseHard, G13_needles_are_hit_as_often_as_their_area_says) {
  Device& device = *test::devices().front();
  // 10^4 needles of length 1 and width 1e-6, fanned out over the unit disc.
  Soup soup;
  const double pi = std::acos(-1.0), width = 1e-6;
  for (int i = 0; i < 10'000; ++i) {
    const double a = 2 * pi * i / 10'000, x = std::cos(a), y = std::sin(a);
    fixtures::add_triangle(soup, {float(0.2 * x), float(0.2 * y), 0},
                           {float(1.2 * x - 0.5 * width * y), float(1.2 * y + 0.5 * width * x), 0},
                           {float(1.2 * x + 0.5 * width * y), float(1.2 * y - 0.5 * width * x), 0});
  }
  double area = 0;  // of what float made of them
  for (std::size_t i = 0; i < soup.size(); i += 9) {
    const float* p = &soup[i];
    area +=
        0.5 * std::abs((double(p[3]) - p[0]) * (double(p[7]) - p[1]) - (double(p[4]) - p[1]) * (double(p[6]) - p[0]));
  }
  std::mt19937 random(41);
  std::uniform_real_distribution<float> unit(-1.5F, 1.5F);
  std::vector<ProbeRay> rays(1'000'000);
  for (ProbeRay& ray : rays) {
    ray.o = {unit(random), unit(random), 1};
    ray.d = {0, 0, -1};
  }
  TraverseProbe probe(device, soup, {"bvh16"});
  const double expected = area / 9.0, count = static_cast<double>(rays.size());
  const double found = 1.0 - static_cast<double>(misses(probe.closest(rays))) / count;
  EXPECT_NEAR(found, expected, 4 * std::sqrt(expected / count));
}

TEST(TraverseHard, G14_of_coincident_triangles_the_lowest_index_wins) {
  Device& device = *test::devices().front();
  const Soup one = fixtures::bumpy_sphere(6);
  Soup soup;  // each triangle three times, far apart in the list
  for (int copy = 0; copy < 3; ++copy) soup.insert(soup.end(), one.begin(), one.end());
  const auto count = static_cast<std::uint32_t>(one.size() / 9);
  std::mt19937 random(51);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(20'000);
  for (ProbeRay& ray : rays) {
    for (float& d : ray.d) d = unit(random);
  }
  for (const TraverseProbe::Options& way : kWays) {
    const auto hits = TraverseProbe(device, soup, way).closest(rays);
    EXPECT_EQ(misses(hits), 0U) << TraverseProbe::describe(way);
    EXPECT_TRUE(std::all_of(hits.begin(), hits.end(), [&](const ProbeHit& h) { return h.triangle < count; }))
        << TraverseProbe::describe(way);
  }
}

TEST(TraverseHard, G15_ten_thousand_copies_are_hit_as_one_triangle_and_nothing_is_hit_without_any) {
  Device& device = *test::devices().front();
  Soup copies;
  for (int i = 0; i < 10'000; ++i) fixtures::add_triangle(copies, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Soup one(copies.begin(), copies.begin() + 9);
  ProbeRay hit, miss;
  hit.o = miss.o = {0.25F, 0.25F, 1};
  hit.d = {0, 0, -1};
  miss.d = {0, 0, 1};
  for (const TraverseProbe::Options& way : kWays) {
    for (const Soup& soup : {copies, one, Soup{}}) {
      TraverseProbe probe(device, soup, way);
      const auto found = probe.closest({hit, miss});
      EXPECT_EQ(found[0].triangle, soup.empty() ? EK_NO_HIT : 0U) << TraverseProbe::describe(way);
      EXPECT_EQ(found[1].triangle, EK_NO_HIT) << TraverseProbe::describe(way);
      EXPECT_EQ(probe.any({hit, miss}), (std::vector<bool>{!soup.empty(), false})) << TraverseProbe::describe(way);
    }
  }
}

}  // namespace
}  // namespace eikon
