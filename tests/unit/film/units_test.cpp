// SPDX-License-Identifier: Apache-2.0
#include "film/units.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace eikon {
namespace {

WorkUnit box(Crop block, std::uint64_t begin, std::uint64_t end) { return {block, begin, end}; }

std::vector<WorkUnit> take_all(UnitPool& pool, std::uint64_t most_paths, std::uint64_t most_samples) {
  std::vector<WorkUnit> units;
  while (const auto unit = pool.take(most_paths, most_samples)) units.push_back(*unit);
  return units;
}

// How often each (pixel, sample) is in a unit.
using TimesCovered = std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>, int>;
void count(TimesCovered& times, const WorkUnit& unit) {
  for (std::uint32_t xy : unit_pixels(unit.block))
    for (std::uint64_t s = unit.sample_begin; s < unit.sample_end; ++s) ++times[{xy & 0xffff, xy >> 16, s}];
}

TEST(Units, every_pixel_and_sample_is_in_exactly_one_unit) {
  const Crop crops[] = {{0, 0, 1, 1}, {0, 0, 37, 23}, {5, 9, 70, 75}, {0, 0, 1, 130}, {3, 0, 67, 1}};
  for (const Crop& crop : crops)
    for (std::uint64_t capacity : {1ULL, 7ULL, 64ULL, 1000ULL, 65536ULL})
      for (std::uint32_t block : {1U, 16U, 64U}) {
        UnitPool pool(block);
        pool.add(box(crop, 3, 12));
        EXPECT_EQ(pool.path_count(), crop.pixel_count() * 9);
        TimesCovered times;
        for (const WorkUnit& unit : take_all(pool, capacity, 4)) {
          ASSERT_LE(unit.path_count(), capacity);
          ASSERT_LE(unit.sample_end - unit.sample_begin, 4U);
          ASSERT_LE(std::max(unit.block.width(), unit.block.height()), block);
          count(times, unit);
        }
        EXPECT_EQ(times.size(), crop.pixel_count() * 9) << capacity << " " << block;
        for (const auto& [where, n] : times) ASSERT_EQ(n, 1);
        EXPECT_EQ(pool.path_count(), 0U);
      }
}

TEST(Units, do_not_cross_the_period_however_the_boxes_are_joined) {
  UnitPool pool(32);
  pool.set_period(8);
  pool.add(box({0, 0, 30, 20}, 3, 50));
  pool.add(box({0, 0, 30, 20}, 50, 61));
  TimesCovered times;
  for (const WorkUnit& unit : take_all(pool, 1 << 20, 1 << 20)) {
    EXPECT_EQ(unit.sample_begin / 8, (unit.sample_end - 1) / 8) << unit.sample_begin << ' ' << unit.sample_end;
    count(times, unit);
  }
  EXPECT_EQ(times.size(), 600U * 58);
}

TEST(Units, units_of_any_sizes_and_some_given_back_are_everything_once) {
  std::mt19937 random(5);
  for (int round = 0; round < 6; ++round) {
    UnitPool pool(32);
    pool.add(box({3, 5, 100, 80}, 7, 30));
    TimesCovered times;
    while (!pool.empty()) {
      const std::uint64_t left = pool.path_count();
      const WorkUnit unit = *pool.take(1 + random() % (random() % 2 == 0 ? 9000 : 60), 1 + random() % 9);
      ASSERT_EQ(pool.path_count() + unit.path_count(), left);
      if (random() % 4 == 0)
        pool.add(unit);
      else
        count(times, unit);
    }
    ASSERT_EQ(times.size(), 97U * 75 * 23);
    for (const auto& [where, n] : times) ASSERT_EQ(n, 1);
  }
}

TEST(Units, N3_no_unit_crosses_a_multiple_of_2_to_the_32_and_none_is_left_out) {
  constexpr std::uint64_t period = std::uint64_t{1} << 32;
  UnitPool pool(64);
  pool.add(box({0, 0, 1, 1}, period - 10, 4 * period + 7));
  std::uint64_t next = period - 10;
  for (const WorkUnit& unit : take_all(pool, period - 3, period)) {
    EXPECT_EQ(unit.sample_begin, next);
    EXPECT_EQ(unit.sample_begin / period, (unit.sample_end - 1) / period);
    next = unit.sample_end;
  }
  EXPECT_EQ(next, 4 * period + 7);
}

TEST(Units, N13_any_number_of_samples_takes_no_memory) {
  constexpr std::uint64_t most = std::uint64_t{1} << 48;
  UnitPool pool(64);
  pool.add(box({0, 0, 128, 64}, 5, most));
  for (int i = 0; i < 10000; ++i) {
    ASSERT_LE(pool.take(3 * 4096, 1000)->path_count(), 3U * 4096);
    ASSERT_LE(pool.box_count(), 2U);
  }
}

TEST(Units, all_blocks_come_before_the_next_samples) {
  UnitPool pool(32);
  pool.add(box({0, 0, 100, 100}, 0, 64));
  std::uint64_t last = 0;
  for (const WorkUnit& unit : take_all(pool, 32 * 32 * 4, 64)) {
    EXPECT_GE(unit.sample_begin, last);
    last = unit.sample_begin;
  }
}

TEST(Units, blocks_are_nearly_equal_and_of_whole_tiles) {
  UnitPool pool(128);
  pool.add(box({0, 0, 1280, 720}, 0, 1));
  for (const WorkUnit& unit : take_all(pool, 1U << 20, 1)) {
    EXPECT_EQ(unit.block.width(), 128U);
    EXPECT_EQ(unit.block.height(), 120U);
  }
}

TEST(Units, a_large_block_is_cut_into_nearly_square_parts_of_at_most_so_many_pixels) {
  for (const Crop& crop : {Crop{0, 0, 1920, 1080}, Crop{7, 3, 1000, 60}, Crop{0, 0, 3, 900}, Crop{5, 5, 6, 6}})
    for (const std::uint64_t most : {7ULL, 1000ULL, 131072ULL, 1ULL << 22}) {
      UnitPool pool(4096);
      pool.add(box(crop, 0, 5));
      std::uint64_t paths = 0, units = 0;
      while (units < 300) {
        const auto unit = pool.take(1U << 30, 5, most);
        if (!unit) break;
        const std::uint64_t width = unit->block.width(), height = unit->block.height();
        EXPECT_LE(width * height, most);
        EXPECT_EQ(unit->sample_end, 5U);
        if (most >= 1000 && crop.height() > 500 && crop.width() > 500) {
          EXPECT_LE(std::max(width, height), 2 * std::min(width, height));
        }
        paths += unit->path_count(), ++units;
      }
      EXPECT_EQ(paths + pool.path_count(), 5 * crop.pixel_count());
      if (most >= 1000 && units < 300) {
        EXPECT_LE(units, 2 * (crop.pixel_count() + most - 1) / most) << most;
      }
    }
}

TEST(Units, parts_of_any_sizes_are_everything_once) {
  std::mt19937 random(11);
  UnitPool pool(1024);
  pool.add(box({3, 5, 100, 80}, 7, 30));
  TimesCovered times;
  while (!pool.empty()) count(times, *pool.take(1 + random() % 9000, 1 + random() % 9, random() % 3 == 0 ? 50 : 1000));
  ASSERT_EQ(times.size(), 97U * 75 * 23);
  for (const auto& [where, n] : times) ASSERT_EQ(n, 1);
}

TEST(Units, pieces_of_a_block_become_whole_again) {
  UnitPool pool(128);
  pool.add(box({0, 0, 512, 256}, 0, 1024));
  (void)pool.take(500, 16);  // a piece of one block, one sample: the rest is in pieces
  EXPECT_GT(pool.box_count(), 8U);
  for (int i = 0; i < 40; ++i) (void)pool.take(128 * 128 * 16, 16);
  EXPECT_EQ(pool.box_count(), 8U);
}

TEST(Units, an_empty_crop_or_range_has_no_unit) {
  UnitPool pool(64);
  pool.add(box({4, 4, 4, 9}, 0, 8));
  pool.add(box({0, 0, 4, 4}, 8, 8));
  EXPECT_TRUE(pool.empty());
  EXPECT_FALSE(pool.take(1024, 16));
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
