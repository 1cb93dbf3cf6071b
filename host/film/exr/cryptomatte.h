// SPDX-License-Identifier: Apache-2.0
// Mattes as a picture has them, by the Cryptomatte specification, version 1.2 [Psyop, github.com/Psyop/Cryptomatte].
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "film/film.h"

namespace eikon {

/// Of each pixel the ids that most samples met, most of them first (of as many, the smaller id), with the share of samples that
/// did. What met nothing has no id, but counts: the shares then do not add up to 1.
class MatteRanks {
 public:
  static constexpr std::size_t kRanks = 6, kChannels = 2 * kRanks;
  /// The film must live as long as this.
  MatteRanks(const Film& film, std::size_t matte) : film_(film), matte_(matte) {}
  /// Channel 2 r is the id of rank r, as the float of its bits; 2 r + 1 its share. Quick along the channels of a few rows.
  [[nodiscard]] float value(std::uint32_t x, std::uint32_t y, std::size_t channel);

 private:
  static constexpr std::uint32_t kRows = 16;
  using Ranks = std::array<float, kChannels>;
  const Film& film_;
  std::size_t matte_;
  std::vector<Ranks> block_;           // of some rows
  std::uint32_t begin_ = 0, end_ = 0;  // which
  [[nodiscard]] Ranks ranks(std::uint32_t x, std::uint32_t y) const;
};

/// "LAYER00.R", ..., in the order of MatteRanks::value.
[[nodiscard]] std::vector<std::string> matte_channels(const std::string& layer);
/// Attributes of the header: "cryptomatte/<key>/name" and so on.
[[nodiscard]] std::map<std::string, std::string> matte_attributes(const std::string& layer,
                                                                  const std::string& manifest);

}  // namespace eikon
