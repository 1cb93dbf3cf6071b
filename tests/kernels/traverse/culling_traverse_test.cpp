// SPDX-License-Identifier: Apache-2.0
// Camera rays pass the backs of single-sided triangles: every layout and width gives the hits of
// brute force, and those are the nearest ones that are no such backs.
#include <gtest/gtest.h>

#include <cstring>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using fixtures::Soup;

Soup scattered(std::size_t count, float size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const float center[3] = {unit(random), unit(random), unit(random)};
    for (int k = 0; k < 9; ++k) soup.push_back(center[k % 3] + size * unit(random));
  }
  return soup;
}

/// The same triangles twice, turned over the second time: at each place one of the two has its
/// front to a ray.
Soup with_turned_copies(const Soup& soup) {
  Soup all = soup;
  for (std::size_t i = 0; i < soup.size(); i += 9)
    for (const std::size_t corner : {0U, 2U, 1U})
      all.insert(all.end(), soup.begin() + std::ptrdiff_t(i + 3 * corner),
                 soup.begin() + std::ptrdiff_t(i + 3 * corner + 3));
  return all;
}

std::vector<ProbeRay> rays_inwards(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(count);
  for (ProbeRay& ray : rays)
    for (std::size_t k = 0; k < 3; ++k) {
      ray.o[k] = 1.5F * unit(random);
      ray.d[k] = 0.5F * unit(random) - ray.o[k];
    }
  return rays;
}

/// Cosine of the ray with the front's normal, times lengths: negative where the ray comes from the
/// front.
double along_normal(const Soup& soup, std::size_t triangle, const ProbeRay& ray) {
  const auto at = [&](std::size_t corner) {
    const float* p = &soup[9 * triangle + 3 * corner];
    return glm::dvec3(p[0], p[1], p[2]);
  };
  return glm::dot(glm::cross(at(1) - at(0), at(2) - at(0)), glm::dvec3(ray.d[0], ray.d[1], ray.d[2]));
}

TraverseProbe::Options culling(TraverseProbe::Options options, const std::vector<std::uint32_t>& flags) {
  options.culled = flags;
  return options;
}

void expect_all_agree(const Soup& soup, const std::vector<std::uint32_t>& flags, const std::string& what) {
  const std::vector<ProbeRay> rays = rays_inwards(4'000, 4);
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe brute(device, soup, culling({"none", 1}, flags)), plain(device, soup, {"none", 1});
    const std::vector<ProbeHit> closest = brute.closest(rays), both_sides = plain.closest(rays);
    const std::vector<bool> any = plain.any(rays);
    const auto is_culled = [&](const ProbeHit& hit, const ProbeRay& ray) {
      return flags[hit.triangle] != 0 && along_normal(soup, hit.triangle, ray) > 0;
    };
    std::size_t passed = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (closest[i].triangle != EK_NO_HIT) {
        ASSERT_FALSE(is_culled(closest[i], rays[i])) << what << " ray " << i;
      }
      if (both_sides[i].triangle == EK_NO_HIT || !is_culled(both_sides[i], rays[i])) {
        ASSERT_EQ(std::memcmp(&both_sides[i], &closest[i], sizeof(ProbeHit)), 0) << what << " ray " << i;
        continue;
      }
      ++passed;
      ASSERT_GE(closest[i].t, both_sides[i].t) << what << " ray " << i;
    }
    EXPECT_GT(passed, rays.size() / 10) << what;
    EXPECT_EQ(brute.any(rays), any) << what << ": shadow rays meet both sides";
    for (const TraverseProbe::Options& variant : TraverseProbe::each_once()) {
      TraverseProbe probe(device, soup, culling(variant, flags));
      const std::string name = what + ", " + TraverseProbe::describe(variant);
      const std::vector<ProbeHit> hits = probe.closest(rays);
      std::size_t different = 0, first = 0;
      for (std::size_t i = 0; i < rays.size(); ++i)
        if (std::memcmp(&hits[i], &closest[i], sizeof(ProbeHit)) != 0 && different++ == 0) first = i;
      EXPECT_EQ(different, 0U) << name << ": first ray " << first << ", triangle " << hits[first].triangle << " not "
                               << closest[first].triangle;
      EXPECT_EQ(probe.any(rays), any) << name;
    }
  }
}

TEST(CullingTraverse, hits_are_the_same_bits_in_every_layout) {
  // The kernels treat trees of up to 2047 triangles in another way than larger ones.
  for (const std::size_t count : {300U, 4000U}) {
    std::vector<std::uint32_t> flags(count, EK_TRIANGLE_SINGLE_SIDED);
    for (std::size_t i = 0; i < count; i += 3) flags[i] = 0;
    expect_all_agree(scattered(count, count < 1000 ? 0.3F : 0.12F, 1), flags, std::to_string(count));
  }
}

TEST(CullingTraverse, of_a_triangle_and_its_turned_copy_the_one_that_shows_its_front_is_hit) {
  const Soup soup = with_turned_copies(scattered(1500, 0.15F, 2));
  const std::vector<std::uint32_t> flags(soup.size() / 9, EK_TRIANGLE_SINGLE_SIDED);
  expect_all_agree(soup, flags, "pairs");
  const std::vector<ProbeRay> rays = rays_inwards(4'000, 4);
  for (const auto& opened : test::devices()) {
    TraverseProbe all(*opened, soup, {"bvh16", 16}), culled(*opened, soup, culling({"bvh16", 16}, flags));
    const std::vector<ProbeHit> a = all.closest(rays), b = culled.closest(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(a[i].triangle == EK_NO_HIT, b[i].triangle == EK_NO_HIT) << "ray " << i;
      if (a[i].triangle == EK_NO_HIT) continue;
      ASSERT_NEAR(a[i].t, b[i].t, 1e-4) << "ray " << i;
    }
  }
}

}  // namespace
}  // namespace eikon
