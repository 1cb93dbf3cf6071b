// SPDX-License-Identifier: Apache-2.0
// Every layout at every lane width gives the hits of brute force, bit for bit.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <memory>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using fixtures::Soup;

std::vector<ProbeRay> random_rays(std::size_t count, float scale, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(count);
  for (ProbeRay& ray : rays) {
    for (float& x : ray.o) x = 1.5F * scale * unit(random);
    for (float& x : ray.d) x = unit(random);
    ray.t_max = scale * (1.0F + unit(random));
  }
  return rays;
}

/// Rays that ask for trouble: along axes, with zeros of both signs, at vertices, edges and box
/// corners, from on surfaces.
std::vector<ProbeRay> adversarial_rays(const Soup& soup, std::size_t count, float scale, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<ProbeRay> rays = random_rays(count, scale, seed + 1);
  std::uniform_int_distribution<std::size_t> triangle(0, soup.size() / 9 - 1);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  for (std::size_t i = 0; i < count; ++i) {
    ProbeRay& ray = rays[i];
    const float* p = &soup[9 * triangle(random)];
    const float w = unit(random);
    std::array<float, 3> target{};
    for (std::size_t k = 0; k < 3; ++k) {
      switch (i % 3) {
        case 0:
          target[k] = p[k];
          break;  // a vertex
        case 1:
          target[k] = p[k] + w * (p[3 + k] - p[k]);
          break;  // an edge
        default:
          target[k] = (p[k] + p[3 + k] + p[6 + k]) / 3;
          break;  // inside
      }
    }
    switch (i / 3 % 5) {
      case 0:  // aimed at it
        for (std::size_t k = 0; k < 3; ++k) ray.d[k] = target[k] - ray.o[k];
        break;
      case 1:  // from it
        ray.o = target;
        break;
      case 2:  // along an axis through it
        ray.o = target;
        ray.d = {i % 2 == 0 ? 0.0F : -0.0F, i % 4 < 2 ? 0.0F : -0.0F, 0.0F};
        ray.d[i / 15 % 3] = i % 7 < 3 ? 1.0F : -1.0F;
        ray.o[i / 15 % 3] -= (i % 5 == 0 ? 0.0F : 2.0F) * scale * ray.d[i / 15 % 3];
        break;
      case 3:  // in an axis plane through it
        ray.o[i % 3] = target[i % 3];
        ray.d[i % 3] = i % 2 == 0 ? 0.0F : -0.0F;
        break;
      default:  // nearly along an edge
        for (std::size_t k = 0; k < 3; ++k) ray.d[k] = p[3 + k] - p[k];
        for (std::size_t k = 0; k < 3; ++k) ray.o[k] = target[k] - 3 * ray.d[k];
        break;
    }
  }
  return rays;
}

::testing::AssertionResult same_bits(const std::vector<ProbeHit>& a, const std::vector<ProbeHit>& b,
                                     const std::vector<ProbeRay>& rays) {
  std::size_t different = 0, first = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(ProbeHit)) != 0 && different++ == 0) first = i;
  }
  if (different == 0) return ::testing::AssertionSuccess();
  const ProbeRay& r = rays[first];
  return ::testing::AssertionFailure() << different << " of " << a.size() << " differ, first ray " << first
                                       << std::hexfloat << " o " << r.o[0] << ' ' << r.o[1] << ' ' << r.o[2] << " d "
                                       << r.d[0] << ' ' << r.d[1] << ' ' << r.d[2] << ": t " << a[first].t << " u "
                                       << a[first].u << " v " << a[first].v << " triangle " << a[first].triangle
                                       << " against t " << b[first].t << " u " << b[first].u << " v " << b[first].v
                                       << " triangle " << b[first].triangle;
}

template <class T>
std::vector<T> first(const std::vector<T>& all, std::size_t count) {
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// `soup` in every layout and width; the rays' hits must be those of brute force at width 16.
void expect_all_agree(const Soup& soup, const std::vector<ProbeRay>& rays, const std::string& what) {
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe brute(device, soup, {"none", 16});
    const auto closest = brute.closest(rays);
    const auto any = brute.any(rays);
    std::size_t hit_count = 0, blocked_count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      hit_count += closest[i].triangle != EK_NO_HIT ? 1 : 0;
      blocked_count += any[i] ? 1 : 0;
      // Any-hit agrees with the closest hit by definition.
      EXPECT_EQ(any[i], closest[i].triangle != EK_NO_HIT && closest[i].t < rays[i].t_max) << what << " ray " << i;
      EXPECT_EQ(closest[i].triangle == EK_NO_HIT, std::isinf(closest[i].t)) << what << " ray " << i;
    }
    EXPECT_GT(hit_count, rays.size() / 50) << what;  // the comparison below is of hits, not of misses
    EXPECT_LT(blocked_count, rays.size()) << what;
    // Rays that end at what they hit, one unit before and one behind.
    std::vector<ProbeRay> ending = rays;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const float t = closest[i].t;
      if (std::isfinite(t)) ending[i].t_max = i % 3 == 0 ? t : std::nextafter(t, i % 3 == 1 ? 0.0F : INFINITY);
    }
    const auto any_ending = brute.any(ending);
    for (std::size_t i = 0; i < rays.size(); ++i)
      EXPECT_EQ(any_ending[i], closest[i].triangle != EK_NO_HIT && closest[i].t < ending[i].t_max)
          << what << " ray " << i;
    for (const auto& variant : TraverseProbe::variants()) {
      TraverseProbe probe(device, soup, variant);
      const std::string name = what + ", " + TraverseProbe::describe(variant);
      // Brute force at the other width takes as long as the reference: the first rays will do.
      const std::size_t count = variant.method == "none" ? std::min<std::size_t>(rays.size(), 2000) : rays.size();
      EXPECT_TRUE(same_bits(probe.closest(first(rays, count)), closest, rays)) << name;
      EXPECT_EQ(probe.any(first(rays, count)), first(any, count)) << name;
      EXPECT_EQ(probe.any(first(ending, count)), first(any_ending, count)) << name;
    }
  }
}

TEST(Traverse, random_rays_hit_the_same_bits_in_every_layout) {
  expect_all_agree(fixtures::scattered(3000, 1.0F, 1), random_rays(20'000, 1.0F, 2), "scattered");
  expect_all_agree(fixtures::scattered(300, 1.0F, 8), random_rays(20'000, 1.0F, 9), "few");
  expect_all_agree(fixtures::bumpy_sphere(20), random_rays(20'000, 1.0F, 3), "sphere");
}

TEST(Traverse, adversarial_rays_hit_the_same_bits_in_every_layout) {
  const Soup scattered = fixtures::scattered(1000, 1.0F, 4), sphere = fixtures::bumpy_sphere(24);
  expect_all_agree(scattered, adversarial_rays(scattered, 20'000, 1.0F, 5), "scattered");
  expect_all_agree(sphere, adversarial_rays(sphere, 20'000, 1.0F, 6), "sphere");
}

TEST(Traverse, a_ray_does_not_meet_the_triangle_that_it_leaves_nor_the_one_that_it_goes_to) {
  Soup soup = fixtures::scattered(500, 1.0F, 61);
  for (const float corner : {-4.0F, 4.0F})  // nothing else bounds the scene
    for (int i = 0; i < 9; ++i) soup.push_back(corner + (i == 4 ? 0.001F : i == 8 ? 0.002F : 0.0F));
  std::vector<ProbeRay> rays = random_rays(20'000, 1.0F, 62);
  Device& device = *test::devices().front();
  const TraverseProbe::Options brute_force{"none", 16};
  const std::vector<ProbeHit> first = TraverseProbe(device, soup, brute_force).closest(rays);
  std::map<std::uint32_t, std::size_t> hits;
  for (const ProbeHit& hit : first) ++hits[hit.triangle];
  hits.erase(EK_NO_HIT);
  ASSERT_GT(hits.size(), 50U);
  const std::uint32_t gone = std::max_element(hits.begin(), hits.end(), [](const auto& a, const auto& b) {
                               return a.second < b.second;
                             })->first;
  Soup without = soup;
  for (std::size_t i = 3; i < 9; ++i) without[9 * gone + i] = without[9 * gone + i % 3];
  TraverseProbe other(device, without, brute_force);
  const std::vector<ProbeHit> behind = other.closest(rays);
  const std::vector<bool> any_behind = other.any(rays);
  EXPECT_FALSE(same_bits(first, behind, rays));

  // The ends of a ray: left, or the goal, which counts for any-hit queries alone.
  std::vector<ProbeRay> leaving = rays, arriving = rays;
  for (ProbeRay& ray : leaving) ray.left = gone;
  for (ProbeRay& ray : arriving) ray.goal = gone;
  for (const auto& variant : TraverseProbe::variants()) {
    TraverseProbe probe(device, soup, variant);
    const std::string name = TraverseProbe::describe(variant);
    EXPECT_TRUE(same_bits(probe.closest(leaving), behind, rays)) << name;
    EXPECT_TRUE(same_bits(probe.closest(arriving), first, rays)) << name;
    EXPECT_EQ(probe.any(leaving), any_behind) << name;
    EXPECT_EQ(probe.any(arriving), any_behind) << name;
  }
  // Each its own: where it goes on is behind.
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].left = first[i].triangle;
  const std::vector<ProbeHit> second = TraverseProbe(device, soup, brute_force).closest(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (first[i].triangle == EK_NO_HIT) continue;
    EXPECT_NE(second[i].triangle, first[i].triangle);
    EXPECT_GE(second[i].t, first[i].t);
  }
  for (const auto& variant : TraverseProbe::variants())
    EXPECT_TRUE(same_bits(TraverseProbe(device, soup, variant).closest(rays), second, rays))
        << TraverseProbe::describe(variant);
}

TEST(Traverse, scenes_far_from_the_origin_hit_the_same_bits_in_every_layout) {
  // Of the largest coordinates, a float's steps are as large as the smallest triangles: most planes
  // round, many boxes are flat.
  for (const float far : {3e4F, 1e6F}) {
    Soup soup = fixtures::scattered(2500, 2.0F, 10);
    std::vector<ProbeRay> rays = adversarial_rays(soup, 15'000, 2.0F, 11);
    const float to[3] = {far, -0.7F * far, 0.1F * far};
    for (std::size_t i = 0; i < soup.size(); ++i) soup[i] += to[i % 3];
    for (ProbeRay& ray : rays)
      for (std::size_t k = 0; k < 3; ++k) ray.o[k] += to[k];
    expect_all_agree(soup, rays, "far away");
  }
}

TEST(Traverse, rays_in_faces_edges_and_corners_of_cells_hit_the_same_bits_in_every_layout) {
  // Whole coordinates from 0 to 16, so that the planes of octree, kd-tree and grid pass through
  // vertices; a huge triangle cuts through all.
  std::mt19937 random(31);
  std::uniform_int_distribution<int> whole(0, 16), step(-1, 1);
  Soup soup;
  fixtures::add_triangle(soup, {0, 0, 0}, {16, 16, 0}, {16, 0, 16});
  for (int i = 0; i < 700; ++i) {
    const int x = whole(random), y = whole(random), z = whole(random);
    const auto corner = [&](int c) { return static_cast<float>(std::clamp(c + step(random), 0, 16)); };
    fixtures::add_triangle(soup, {float(x), float(y), float(z)}, {corner(x), corner(y), corner(z)},
                           {corner(x), corner(y), corner(z)});
  }
  std::vector<ProbeRay> rays(20'000);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ProbeRay& ray = rays[i];
    ray.t_max = 5;
    for (float& x : ray.o) x = 0.5F * static_cast<float>(whole(random) + (i % 2 == 0 ? whole(random) : 16));
    for (float& x : ray.d) x = static_cast<float>(step(random));
    if (i % 5 == 0) ray.d[i % 3] = 0x1p-70F;  // nearly in the face
    if (ray.d == std::array<float, 3>{}) ray.d[i % 3] = -1;
  }
  expect_all_agree(soup, rays, "lattice");
}

TEST(Traverse, rays_from_far_away_hit_the_same_bits_in_every_layout) {
  // From beyond what cells are grown for, up to where the error of a ray is a cell, a triangle, and
  // the scene.
  const Soup soup = fixtures::scattered(1500, 1.0F, 33);
  std::vector<ProbeRay> rays = adversarial_rays(soup, 20'000, 1.0F, 34);
  std::mt19937 random(35);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const float away = std::exp2(3.0F + 16.0F * static_cast<float>(i) / static_cast<float>(rays.size()));
    const float* p = &soup[9 * (i % (soup.size() / 9))];
    float longest = 0;
    for (float& d : rays[i].d) d = unit(random), longest = std::max(longest, std::abs(d));
    for (std::size_t k = 0; k < 3; ++k) {
      rays[i].d[k] /= longest;
      rays[i].o[k] = p[k] - away * rays[i].d[k];
    }
    rays[i].t_max = away;
  }
  expect_all_agree(soup, rays, "from far away");
}

TEST(Traverse, rays_within_an_oblique_plane_of_slivers_hit_the_same_bits_in_every_layout) {
  // All corners and rays lie in one plane but for rounding: the computed t of a triangle seen
  // edge-on can lie far outside its box, and only the interval rule keeps the layouts together.
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  const auto in_plane = [](float a, float b) {
    return std::array<float, 3>{0.6F * a - 0.3F * b, 0.5F * a + 0.7F * b, 0.62F * a - 0.33F * b};
  };
  Soup soup;
  for (int i = 0; i < 2500; ++i) {
    const float a = unit(random), b = unit(random);
    for (int corner = 0; corner < 3; ++corner) {
      const auto p = in_plane(a + 0.3F * unit(random), b + 0.3F * unit(random));
      soup.insert(soup.end(), p.begin(), p.end());
    }
  }
  std::vector<ProbeRay> rays(100'000);
  for (ProbeRay& ray : rays) {
    ray.o = in_plane(2 * unit(random), 2 * unit(random));
    ray.d = in_plane(unit(random), unit(random));
    ray.t_max = 0.3F;
  }
  expect_all_agree(soup, rays, "slivers");
}

TEST(Traverse, many_rays_hit_the_same_bits_as_brute_force) {
  // EIKON_TRAVERSE_RAYS: how many rays for each of the two scenes; 1e8 have been traced once.
  const char* asked = std::getenv("EIKON_TRAVERSE_RAYS");
  const auto total = static_cast<std::size_t>(asked == nullptr ? 2e5 : std::stod(asked));
  const std::size_t block = std::min<std::size_t>(total, 1'000'000);
  Device& device = *test::devices().front();
  const std::pair<const char*, Soup> scenes[] = {{"scattered", fixtures::scattered(60, 1.0F, 21)},
                                                 {"sphere", fixtures::bumpy_sphere(6)}};
  for (const auto& [name, soup] : scenes) {
    TraverseProbe brute(device, soup, {"none", 16});
    std::vector<std::pair<std::string, std::unique_ptr<TraverseProbe>>> probes;
    for (const TraverseProbe::Options& variant : TraverseProbe::variants()) {
      if (variant.width != 16 || variant.portable || (variant.layout != "bvh16" && variant.layout != "bvh8")) continue;
      probes.emplace_back(TraverseProbe::describe(variant), std::make_unique<TraverseProbe>(device, soup, variant));
    }
    ASSERT_GE(probes.size(), 6U);
    for (std::size_t first = 0; first < total; first += block) {
      const auto seed = static_cast<std::uint32_t>(100 + first / block);
      const auto rays =
          first / block % 2 == 0 ? adversarial_rays(soup, block, 1.0F, seed) : random_rays(block, 1.0F, seed);
      const auto closest = brute.closest(rays);
      const auto any = brute.any(rays);
      for (const auto& [variant, probe] : probes) {
        ASSERT_TRUE(same_bits(probe->closest(rays), closest, rays)) << name << ", " << variant << ", seed " << seed;
        ASSERT_EQ(probe->any(rays), any) << name << ", " << variant << ", seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace eikon
