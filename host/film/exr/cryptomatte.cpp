// SPDX-License-Identifier: Apache-2.0
#include "film/exr/cryptomatte.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "film/mattes.h"

namespace eikon {

MatteRanks::Ranks MatteRanks::ranks(std::uint32_t x, std::uint32_t y) const {
  std::vector<MatteCount> counts = film_.matte(matte_, x, y);
  std::uint64_t all = 0;
  for (const MatteCount& count : counts) all += count.samples;
  std::erase_if(counts, [](const MatteCount& count) { return count.id == 0; });
  std::ranges::stable_sort(counts, std::ranges::greater{}, &MatteCount::samples);
  Ranks ranks{};
  for (std::size_t r = 0; r < std::min(kRanks, counts.size()); ++r) {
    ranks[2 * r] = std::bit_cast<float>(counts[r].id);
    ranks[2 * r + 1] = static_cast<float>(static_cast<double>(counts[r].samples) / static_cast<double>(all));
  }
  return ranks;
}

float MatteRanks::value(std::uint32_t x, std::uint32_t y, std::size_t channel) {
  const Crop& crop = film_.layout().crop;
  if (y < begin_ || y >= end_) {
    begin_ = crop.y0 + (y - crop.y0) / kRows * kRows;
    end_ = std::min(begin_ + kRows, crop.y1);
    block_.clear();
    for (std::uint32_t row = begin_; row < end_; ++row)
      for (std::uint32_t column = crop.x0; column < crop.x1; ++column) block_.push_back(ranks(column, row));
  }
  return block_[std::size_t{y - begin_} * crop.width() + (x - crop.x0)][channel];
}

std::vector<std::string> matte_channels(const std::string& layer) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < MatteRanks::kChannels; ++c)
    names.push_back(fmt::format("{}{:02}.{}", layer, c / 4, "RGBA"[c % 4]));
  return names;
}

std::map<std::string, std::string> matte_attributes(const std::string& layer, const std::string& manifest) {
  const std::string prefix = fmt::format("cryptomatte/{}/", matte_hex(matte_id(layer)).substr(0, 7));
  return {{prefix + "name", layer},
          {prefix + "hash", "MurmurHash3_32"},
          {prefix + "conversion", "uint32_to_float32"},
          {prefix + "manifest", manifest}};
}

}  // namespace eikon
