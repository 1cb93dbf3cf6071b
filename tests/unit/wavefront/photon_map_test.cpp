// SPDX-License-Identifier: Apache-2.0
#include "wavefront/photons/photon_map.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <set>

#include "guide/guide_table.h"

namespace eikon {
namespace {

constexpr float kRadius2 = 0.01F, kScale = 5;

std::vector<std::uint32_t> some_photons(std::size_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-1, 1);
  std::vector<std::uint32_t> words(count * PHOTON_WORDS);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      words[i * PHOTON_WORDS + axis] = std::bit_cast<std::uint32_t>(place(random));
    words[i * PHOTON_WORDS + PHOTON_info] = std::uint32_t(random() % 2 | (2 + random() % 3) << 16);
    words[i * PHOTON_WORDS + PHOTON_order] = std::uint32_t(random());
  }
  return words;
}

/// As photon_bucket of the kernels.
std::uint32_t bucket_at(const PhotonMap& map, const float* p, std::uint32_t replicate) {
  const auto cell = [&](std::size_t axis) { return std::uint32_t(int(std::floor(p[axis] * kScale)) + 32768); };
  return cell_hash(cell(0) | cell(1) << 16, cell(2) | replicate << 16) & std::uint32_t(map.buckets.size() - 2);
}

TEST(PhotonMap, holds_every_photon_once_in_the_bucket_of_each_point_near_it) {
  const PhotonMap map = make_photon_map(some_photons(400), kRadius2, kScale);
  const std::size_t count = map.photons.size() / PHOTON_WORDS;
  ASSERT_EQ(count, 400U);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> place(-1, 1);
  std::size_t found = 0;
  for (int i = 0; i < 4000; ++i) {
    const float p[3] = {place(random), place(random), place(random)};
    for (std::uint32_t replicate = 0; replicate < 2; ++replicate) {
      const std::uint32_t bucket = bucket_at(map, p, replicate);
      const std::multiset<std::uint32_t> here(map.places.begin() + map.buckets[bucket],
                                              map.places.begin() + map.buckets[bucket + 1]);
      for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t* const words = &map.photons[k * PHOTON_WORDS];
        double distance2 = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
          distance2 += std::pow(double(std::bit_cast<float>(words[axis])) - double(p[axis]), 2);
        if (distance2 > double(kRadius2) || (EK_PHOTON_REPLICATE(words[PHOTON_info])) != replicate) continue;
        ASSERT_EQ(here.count(k), 1U);
        ++found;
      }
    }
  }
  EXPECT_GT(found, 300U);
}

TEST(PhotonMap, does_not_depend_on_the_order_in_which_a_device_finds_photons) {
  const std::vector<std::uint32_t> words = some_photons(100);
  std::vector<std::uint32_t> backwards;
  for (std::size_t i = 100; i-- > 0;)
    backwards.insert(backwards.end(), words.begin() + std::ptrdiff_t(i * PHOTON_WORDS),
                     words.begin() + std::ptrdiff_t((i + 1) * PHOTON_WORDS));
  const PhotonMap a = make_photon_map(words, kRadius2, kScale), b = make_photon_map(backwards, kRadius2, kScale);
  EXPECT_EQ(a.photons, b.photons);
  EXPECT_EQ(a.places, b.places);
  EXPECT_EQ(a.buckets, b.buckets);
}

TEST(PhotonMap, may_be_empty) {
  const PhotonMap map = make_photon_map({}, kRadius2, kScale);
  EXPECT_EQ(map.buckets, (std::vector<std::uint32_t>{0, 0}));
}

TEST(PhotonPlan, has_generations_of_so_many_samples_that_their_light_paths_are_in_the_ratio_asked_for) {
  Settings settings;
  settings.width = 160, settings.height = 120;
  EXPECT_EQ(photon_plan(settings).paths, 0U);
  settings.merges_caustics = true;
  settings.light_path_count = 4800;  // a quarter
  PhotonPlan plan = photon_plan(settings);
  EXPECT_EQ(plan.paths, 16384U);
  EXPECT_EQ(plan.samples, 2U * 4);
  settings.light_path_count = 10;  // a sixteenth is the least
  EXPECT_EQ(photon_plan(settings).samples, 2U * 16);
  settings.width = 7680, settings.height = 4320;
  plan = photon_plan(settings);
  EXPECT_EQ(plan.paths, std::uint64_t{1} << 17) << "memory is bounded";
  EXPECT_EQ(plan.samples, 2U);
  settings.replicate_bits = 8;
  EXPECT_EQ(photon_plan(settings).paths, std::uint64_t{1} << 10);
  settings.width = settings.height = 1;
  EXPECT_EQ(photon_plan(settings).paths, std::uint64_t{1} << 6);
}

TEST(PhotonPlan, has_a_radius_that_falls_as_the_sixth_root_of_the_generations) {
  EXPECT_EQ(photon_radius2(4, 0), 4);
  EXPECT_NEAR(photon_radius2(1, 1), 5.0 / 6, 1e-15);
  const double a = photon_radius2(1, 1000), b = photon_radius2(1, 64000);
  EXPECT_NEAR(std::sqrt(b / a), 0.5, 1e-3);
}

}  // namespace
}  // namespace eikon
