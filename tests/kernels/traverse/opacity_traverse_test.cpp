// SPDX-License-Identifier: Apache-2.0
// Rays that pass surfaces: every layout and width gives the hits of brute force, and those are of
// the triangles that are there.
#include <gtest/gtest.h>

#include <cstring>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using fixtures::Soup;

MaterialRecord material(std::uint32_t mode, float opacity, float cutoff = 0.5F) {
  MaterialRecord record{};
  record.flags = 1U | mode;
  record.opacity = opacity;
  record.alpha_cutoff = cutoff;
  record.base_color_texture = record.metallic_roughness_texture = record.normal_texture = record.emissive_texture =
      EK_NO_TEXTURE;
  return record;
}

enum : std::uint32_t { kOpaque, kHalf, kNothing, kMasked, kCut, kFull };
std::vector<MaterialRecord> materials() {
  return {material(0, 0.0F),                    // opacity means nothing without a mode
          material(EK_MATERIAL_BLEND, 0.5F),    //
          material(EK_MATERIAL_BLEND, 0.0F),    //
          material(EK_MATERIAL_MASK, 0.5F),     // at the cutoff: there
          material(EK_MATERIAL_MASK, 0.4999F),  //
          material(EK_MATERIAL_BLEND, 1.0F)};
}

TraverseProbe::Options options(const std::string& layout, int width, const std::vector<std::uint32_t>& material_of,
                               bool portable = false, bool coherent = false) {
  TraverseProbe::Options o{layout, width, portable, coherent, true, materials(), material_of};
  return o;
}

std::vector<ProbeRay> rays_through(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(count);
  for (ProbeRay& ray : rays) {
    for (std::size_t k = 0; k < 3; ++k) {
      ray.o[k] = 1.5F * unit(random);
      ray.d[k] = 0.5F * unit(random) - ray.o[k];
    }
    ray.t_max = 1.0F + unit(random);
  }
  return rays;
}

std::vector<std::uint32_t> mixed(std::size_t triangles, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> of(triangles);
  for (std::uint32_t& m : of) m = std::uint32_t(random() % 6);
  return of;
}

/// Triangles of about one size in [-1, 1]^3, so many that a ray meets several.
Soup leaves(std::size_t count, float size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const float center[3] = {unit(random), unit(random), unit(random)};
    for (int k = 0; k < 9; ++k) soup.push_back(center[k % 3] + size * unit(random));
  }
  return soup;
}

/// Stacks of triangles with the same corners: ties in t wherever a ray meets one, within a leaf and
/// across leaves.
Soup stacks(std::size_t count, std::size_t height) {
  const Soup one = leaves(count, 0.4F, 12);
  Soup soup;
  for (std::size_t level = 0; level < height; ++level) soup.insert(soup.end(), one.begin(), one.end());
  return soup;
}

void expect_all_agree(const Soup& soup, const std::string& what) {
  const std::vector<std::uint32_t> of = mixed(soup.size() / 9, 3);
  const std::vector<ProbeRay> rays = rays_through(6'000, 4);
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe brute(device, soup, options("none", 1, of));
    const std::vector<ProbeHit> closest = brute.closest(rays);
    const std::vector<bool> any = brute.any(rays);
    std::size_t on_half = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(any[i], closest[i].triangle != EK_NO_HIT && closest[i].t < rays[i].t_max) << what << " ray " << i;
      if (closest[i].triangle == EK_NO_HIT) continue;
      const std::uint32_t m = of[closest[i].triangle];
      ASSERT_TRUE(m != kNothing && m != kCut) << what << " ray " << i;
      on_half += m == kHalf ? 1 : 0;
    }
    EXPECT_GT(on_half, rays.size() / 50) << what;
    for (const TraverseProbe::Options& variant : TraverseProbe::each_once()) {
      TraverseProbe::Options with = options(variant.layout, variant.width, of, variant.portable, variant.coherent);
      with.defines = variant.defines;
      TraverseProbe probe(device, soup, with);
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

TEST(OpacityTraverse, M22_hits_are_the_same_bits_in_every_layout) {
  // The kernels treat trees of up to 2047 triangles in another way than larger ones.
  expect_all_agree(leaves(300, 0.3F, 1), "few");
  expect_all_agree(leaves(4000, 0.12F, 2), "many");
}

TEST(OpacityTraverse, M22_of_coincident_triangles_the_first_that_is_there_wins) {
  expect_all_agree(stacks(60, 12), "small stacks");
  expect_all_agree(stacks(300, 12), "stacks");
}

TEST(OpacityTraverse, M22_a_surface_that_is_nowhere_is_as_none) {
  const Soup soup = leaves(3000, 0.12F, 5);
  const std::vector<std::uint32_t> of = mixed(soup.size() / 9, 6);
  std::vector<std::uint32_t> with, without, original;  // halves count as opaque here
  Soup rest;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const bool there = of[i] != kNothing && of[i] != kCut;
    with.push_back(there ? std::uint32_t(kOpaque) : of[i]);
    if (!there) continue;
    original.push_back(std::uint32_t(i));
    rest.insert(rest.end(), &soup[9 * i], &soup[9 * i] + 9);
  }
  const std::vector<ProbeRay> rays = rays_through(20'000, 7);
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe probe(device, soup, options("bvh16", 16, with));
    TraverseProbe plain(device, rest, {"bvh16", 16});
    const std::vector<ProbeHit> hits = probe.closest(rays), expected = plain.closest(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const bool missed = expected[i].triangle == EK_NO_HIT;
      ASSERT_EQ(hits[i].triangle, missed ? EK_NO_HIT : original[expected[i].triangle]) << "ray " << i;
      ASSERT_EQ(hits[i].t, expected[i].t) << "ray " << i;
    }
    EXPECT_EQ(probe.any(rays), plain.any(rays));
  }
}

}  // namespace
}  // namespace eikon
