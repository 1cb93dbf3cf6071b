// SPDX-License-Identifier: Apache-2.0
#include "render/units.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace eikon {
namespace {

// How often each (pixel, sample) is in a unit of the plan.
std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>, int> coverage(const UnitPlan& plan) {
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>, int> times;
  for (std::uint64_t i = 0; i < plan.size(); ++i) {
    const WorkUnit unit = plan[i];
    for (std::uint32_t xy : unit_pixels(unit.block))
      for (std::uint64_t s = unit.sample_begin; s < unit.sample_end; ++s) ++times[{xy & 0xffff, xy >> 16, s}];
  }
  return times;
}

TEST(Units, every_pixel_and_sample_is_in_exactly_one_unit) {
  const Crop crops[] = {{0, 0, 1, 1}, {0, 0, 37, 23}, {5, 9, 70, 75}, {0, 0, 1, 130}, {3, 0, 67, 1}};
  for (const Crop& crop : crops)
    for (std::uint64_t capacity : {1ULL, 7ULL, 64ULL, 1000ULL, 65536ULL})
      for (std::uint32_t block : {1U, 16U, 64U}) {
        const UnitPlan plan(crop, 3, 12, block, capacity);
        const auto times = coverage(plan);
        EXPECT_EQ(times.size(), crop.pixel_count() * 9) << capacity << " " << block;
        for (const auto& [where, count] : times) ASSERT_EQ(count, 1);
        for (std::uint64_t i = 0; i < plan.size(); ++i) ASSERT_LE(plan[i].path_count(), capacity);
      }
}

TEST(Units, N3_ranges_are_complete_across_multiples_of_2_to_the_32) {
  constexpr std::uint64_t period = std::uint64_t{1} << 32;
  const std::uint64_t capacity = period - 3;  // one range of a period, and a short one
  const UnitPlan plan({0, 0, 1, 1}, period - 10, 4 * period + 7, 1, capacity);
  std::uint64_t next = period - 10;
  for (std::uint64_t i = 0; i < plan.size(); ++i) {
    EXPECT_EQ(plan[i].sample_begin, next);
    EXPECT_EQ(plan[i].sample_begin / period, (plan[i].sample_end - 1) / period);
    next = plan[i].sample_end;
  }
  EXPECT_EQ(next, 4 * period + 7);
}

TEST(Units, N3_no_unit_crosses_a_multiple_of_2_to_the_32) {
  const std::uint64_t edge = std::uint64_t{1} << 32;
  const UnitPlan plan({0, 0, 2, 2}, edge - 10, edge + 10, 64, 4 * 64);
  std::uint64_t samples = 0;
  for (std::uint64_t i = 0; i < plan.size(); ++i) {
    const WorkUnit unit = plan[i];
    EXPECT_EQ(unit.sample_begin >> 32, (unit.sample_end - 1) >> 32);
    samples += unit.sample_end - unit.sample_begin;
  }
  EXPECT_EQ(samples, 20U);
}

TEST(Units, N13_a_plan_of_any_number_of_samples_takes_no_memory) {
  constexpr std::uint64_t most = std::uint64_t{1} << 48, period = std::uint64_t{1} << 32;
  const UnitPlan plan({0, 0, 64, 64}, 5, most, 64, 3 * 4096);
  EXPECT_EQ(plan[0].sample_begin, 5U);
  EXPECT_EQ(plan[plan.size() - 1].sample_end, most);
  for (std::uint64_t i : {std::uint64_t{0}, period / 3, plan.size() / 2, plan.size() - 2}) {
    EXPECT_EQ(plan[i].sample_end, plan[i + 1].sample_begin) << i;
    EXPECT_LE(plan[i].path_count(), 3U * 4096);
  }
}

TEST(Units, all_blocks_come_before_the_next_samples) {
  const UnitPlan plan({0, 0, 100, 100}, 0, 64, 32, 32 * 32 * 4);
  std::uint64_t last = 0;
  for (std::uint64_t i = 0; i < plan.size(); ++i) {
    EXPECT_GE(plan[i].sample_begin, last);
    last = plan[i].sample_begin;
  }
}

TEST(Units, an_empty_crop_or_range_has_no_unit) {
  EXPECT_EQ(UnitPlan({4, 4, 4, 9}, 0, 8, 64, 1024).size(), 0U);
  EXPECT_EQ(UnitPlan({0, 0, 4, 4}, 8, 8, 64, 1024).size(), 0U);
}

TEST(Units, pixels_come_in_4_by_4_tiles) {
  const std::vector<std::uint32_t> pixels = unit_pixels({8, 8, 16, 16});
  ASSERT_EQ(pixels.size(), 64U);
  for (std::size_t first = 0; first < 64; first += 16) {
    std::set<std::uint32_t> tiles;
    for (std::size_t i = first; i < first + 16; ++i)
      tiles.insert(((pixels[i] & 0xffff) / 4) | ((pixels[i] >> 16) / 4) << 16);
    EXPECT_EQ(tiles.size(), 1U);
  }
}

}  // namespace
}  // namespace eikon
