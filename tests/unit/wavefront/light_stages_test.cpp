// SPDX-License-Identifier: Apache-2.0
// The pixels of a window share the light paths of an image.
#include "wavefront/stages/light_stages.h"

#include <gtest/gtest.h>

#include <numeric>

namespace eikon {
namespace {

TEST(LightStages, every_light_path_belongs_to_one_pixel_of_the_window) {
  for (const Crop& window : {Crop{0, 0, 64, 36}, Crop{10, 3, 17, 8}, Crop{5, 5, 6, 6}})
    for (const std::uint64_t count : {1U, 7U, 144U, 5000U}) {
      std::vector<std::uint32_t> all;
      for (std::uint32_t y = window.y0; y < window.y1; y += 5)
        for (std::uint32_t x = window.x0; x < window.x1; x += 7) {
          const Crop block{x, y, std::min(x + 7, window.x1), std::min(y + 5, window.y1)};
          for (const LightPathRange& range : light_paths_of({count, window}, block))
            for (std::uint32_t i = 0; i < range.count; ++i) all.push_back(range.first + i);
        }
      std::ranges::sort(all);
      std::vector<std::uint32_t> expected(count);
      std::iota(expected.begin(), expected.end(), 0U);
      EXPECT_EQ(all, expected) << count << " in a window of " << window.width() << 'x' << window.height();
    }
}

TEST(LightStages, blocks_of_equal_size_have_equal_shares) {
  const LightPathPlan plan{64 * 36 / 16, {0, 0, 64, 36}};
  for (std::uint32_t x = 0; x < 64; x += 16) {
    std::uint32_t count = 0;
    for (const LightPathRange& range : light_paths_of(plan, {x, 0, x + 16, 36})) count += range.count;
    EXPECT_EQ(count, 36U) << x;
  }
}

/// Takes all light paths of a unit, part by part. Returns the paths of the first part.
std::uint64_t first_part(const WavefrontConfig& config, std::uint64_t numbers, std::uint64_t samples) {
  std::vector<LightUnit::Part> left{{0, numbers, 0, samples}};
  std::uint64_t all = 0, first = 0;
  while (!left.empty()) {
    const LightUnit::Part part = take_light_part(left, config);
    EXPECT_LE(part.end - part.first, config.pixels) << "the numbers stand in the buffer for pixels";
    const std::uint64_t paths = (part.end - part.first) * (part.sample_end - part.sample_begin);
    EXPECT_LE(paths, config.capacity());
    if (first == 0) first = paths;
    all += paths;
  }
  EXPECT_EQ(all, numbers * samples);
  return first;
}

TEST(LightStages, parts_are_as_large_as_the_room_for_splats_and_numbers) {
  WavefrontConfig queued;
  queued.chunk = 1U << 25, queued.pixels = 1U << 20;
  EXPECT_EQ(first_part(queued, 1U << 20, 32), 1U << 22) << "an eighth of the paths in flight";
  EXPECT_EQ(first_part(queued, 1U << 22, 2), 1U << 21) << "the numbers that there is room for";
  queued.chunk = 1U << 10, queued.pixels = 1U << 10;
  EXPECT_EQ(first_part(queued, 1U << 14, 3), 1023U);
  EXPECT_EQ(first_part(queued, 5, 3000), 1024U) << "of one number";
  WavefrontConfig chunked;
  chunked.chunked = true, chunked.chunk = 1U << 12, chunked.chunks = 64, chunked.pixels = kBlockPixels;
  EXPECT_EQ(first_part(chunked, 1U << 20, 1), 1U << 13);
  EXPECT_EQ(first_part(chunked, 1U << 20, 32), 1U << 16);
}

}  // namespace
}  // namespace eikon
