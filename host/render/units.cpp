// SPDX-License-Identifier: Apache-2.0
#include "render/units.h"

#include <algorithm>

namespace eikon {
namespace {

constexpr std::uint64_t kPeriod = std::uint64_t{1} << 32;

}  // namespace

UnitPlan::UnitPlan(const Crop& crop, std::uint64_t sample_begin, std::uint64_t sample_end, std::uint32_t block,
                   std::uint64_t capacity)
    : crop_(crop) {
  if (crop.pixel_count() == 0 || sample_begin >= sample_end) return;
  std::uint32_t side = std::max<std::uint32_t>(block, 1);
  while (std::uint64_t{side} * side > capacity && side > 1) side /= 2;
  block_w_ = std::min(side, crop.width());
  block_h_ = std::min(side, crop.height());
  blocks_x_ = (crop.width() + block_w_ - 1) / block_w_;
  blocks_y_ = (crop.height() + block_h_ - 1) / block_h_;
  samples_ = std::clamp<std::uint64_t>(capacity / (std::uint64_t{block_w_} * block_h_), 1, kPeriod);
  sample_begin_ = sample_begin;
  sample_end_ = sample_end;
  first_end_ = sample_begin + std::min(kPeriod - sample_begin % kPeriod, sample_end - sample_begin);
  const std::uint64_t rest = sample_end - first_end_;
  first_ranges_ = ranges(first_end_ - sample_begin);
  range_count_ = first_ranges_ + rest / kPeriod * ranges(kPeriod) + ranges(rest % kPeriod);
}

std::uint64_t UnitPlan::ranges(std::uint64_t samples) const { return (samples + samples_ - 1) / samples_; }

WorkUnit UnitPlan::operator[](std::uint64_t index) const {
  const std::uint64_t block = index % (blocks_x_ * blocks_y_);
  std::uint64_t range = index / (blocks_x_ * blocks_y_);
  std::uint64_t begin = sample_begin_, end = first_end_;
  if (range >= first_ranges_) {
    range -= first_ranges_;
    begin = first_end_ + range / ranges(kPeriod) * kPeriod;
    end = begin + std::min(kPeriod, sample_end_ - begin);
    range %= ranges(kPeriod);
  }
  WorkUnit unit;
  unit.block.x0 = crop_.x0 + std::uint32_t(block % blocks_x_) * block_w_;
  unit.block.y0 = crop_.y0 + std::uint32_t(block / blocks_x_) * block_h_;
  unit.block.x1 = std::min(unit.block.x0 + block_w_, crop_.x1);
  unit.block.y1 = std::min(unit.block.y0 + block_h_, crop_.y1);
  unit.sample_begin = begin + range * samples_;
  unit.sample_end = unit.sample_begin + std::min(samples_, end - unit.sample_begin);
  return unit;
}

std::vector<std::uint32_t> unit_pixels(const Crop& block) {
  constexpr std::uint32_t tile = 4;
  std::vector<std::uint32_t> pixels;
  pixels.reserve(std::size_t(block.pixel_count()));
  for (std::uint32_t y0 = block.y0; y0 < block.y1; y0 += tile)
    for (std::uint32_t x0 = block.x0; x0 < block.x1; x0 += tile)
      for (std::uint32_t y = y0; y < std::min(y0 + tile, block.y1); ++y)
        for (std::uint32_t x = x0; x < std::min(x0 + tile, block.x1); ++x) pixels.push_back(x | y << 16);
  return pixels;
}

}  // namespace eikon
