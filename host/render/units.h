// SPDX-License-Identifier: Apache-2.0
// How an image is cut into work units: pure functions of plain numbers.
#pragma once
#include <cstdint>
#include <vector>

#include "render/film.h"

namespace eikon {

/// A block of pixels and a half-open range of sample indices, the same for each of them.
struct WorkUnit {
  Crop block;
  std::uint64_t sample_begin = 0, sample_end = 0;
  [[nodiscard]] std::uint64_t path_count() const { return block.pixel_count() * (sample_end - sample_begin); }
};

/// Cuts (crop x samples) into units of at most `capacity` paths: blocks of at most block x block pixels, several samples
/// each, all blocks before the next samples, so that an interrupted image is noisy rather than full of holes. No unit
/// crosses a multiple of 2^32 samples. Every (pixel, sample) is in exactly one unit.
class UnitPlan {
 public:
  UnitPlan(const Crop& crop, std::uint64_t sample_begin, std::uint64_t sample_end, std::uint32_t block,
           std::uint64_t capacity);
  [[nodiscard]] std::uint64_t size() const { return blocks_x_ * blocks_y_ * range_count_; }
  [[nodiscard]] WorkUnit operator[](std::uint64_t index) const;

 private:
  Crop crop_;
  std::uint32_t block_w_ = 1, block_h_ = 1;
  std::uint64_t blocks_x_ = 0, blocks_y_ = 0;
  // Ranges of samples: those up to the first multiple of 2^32, then as many for each 2^32 samples.
  std::uint64_t sample_begin_ = 0, sample_end_ = 0, first_end_ = 0;
  std::uint64_t samples_ = 1, first_ranges_ = 0, range_count_ = 0;

  [[nodiscard]] std::uint64_t ranges(std::uint64_t samples) const;
};

/// Pixels of a block as x | y << 16, in 4 x 4 tiles: neighbouring lanes start with neighbouring rays.
[[nodiscard]] std::vector<std::uint32_t> unit_pixels(const Crop& block);

}  // namespace eikon
