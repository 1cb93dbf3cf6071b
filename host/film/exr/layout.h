// SPDX-License-Identifier: Apache-2.0
// Names and formats that the EXR writer and reader share.
#pragma once
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "film/film.h"
#include "io/xxhash64.h"

namespace eikon::exr {

inline constexpr const char* kImagePart = "image";
inline constexpr const char* kSumsPart = "sums";
inline constexpr const char* kReplicates = "eikon.replicates";  // int, as an attribute of the sums part
inline constexpr const char* kChannels = "eikon.channels";      // string: names joined by commas
inline constexpr const char* kFormat = "eikon.format";          // int: sums_format() of the writer
inline constexpr const char* kRecord = "eikon.record";          // string: ExrOptions::record
inline constexpr const char* kSumsHash = "eikon.sumsHash";      // string: SumsHash of the rest
inline constexpr const char* kMattes = "eikon.mattes";          // string: joined by commas; absent if none
inline constexpr const char* kLightPaths = "eikon.lightPaths";  // string: light_paths_text(); absent if none
// Raised when an older reader would misread the file.
inline constexpr int kSumsFormat = 3;
inline constexpr std::size_t kMaxRecordBytes = std::size_t{64} << 20U;
// Rows of a block of ZIP compression; converted at a time.
inline constexpr int kRowsPerBlock = 16;
inline constexpr std::uint32_t kSumLimbs = 4, kCountLimbs = 2;  // 32-bit words, low first

/// The format of a file with these sums. Readers of format 1 know no mattes, and those of format 2
/// no splats.
inline int sums_format(const FilmLayout& layout) {
  if (layout.channels.back().starts_with(kSplats)) return 3;
  return layout.mattes.empty() ? 1 : 2;
}

/// "x0 y0 x1 y1 n0 n1 ...;..." for each window with the light paths of its replicates.
[[nodiscard]] std::string light_paths_text(std::span<const LightPathCount> counts);
/// The reverse; nothing if the text is no such thing, or if the counts do not belong to the layout.
[[nodiscard]] std::optional<std::vector<LightPathCount>> parse_light_paths(std::string_view text, const FilmLayout& layout);

/// Checksum of a sums part: of its layout and record, then of its numbers row by row, so that
/// writer and reader compute it as rows pass.
class SumsHash {
 public:
  SumsHash(const FilmLayout& layout, const std::string& record, const std::string& light_paths = {})
      : hash_(add(fmt::format("{} {}x{} {},{},{},{} {} {}", sums_format(layout), layout.width, layout.height,
                              layout.crop.x0, layout.crop.y0, layout.crop.x1, layout.crop.y1, layout.replicates,
                              fmt::join(layout.channels, ",")),
                  0)) {
    if (!layout.mattes.empty()) hash_ = add(fmt::format("{}", fmt::join(layout.mattes, ",")), hash_);
    hash_ = add(record, hash_);
    if (!light_paths.empty()) hash_ = add(light_paths, hash_);
  }
  void add_row(std::span<const int128> sums, std::span<const std::uint64_t> counts) {
    static_assert(std::endian::native == std::endian::little, "the checksum is of the numbers' bytes in memory");
    hash_ = xxhash64(std::as_bytes(counts), xxhash64(std::as_bytes(sums), hash_));
  }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_;

  static std::uint64_t add(const std::string& text, std::uint64_t seed) {
    return xxhash64(std::as_bytes(std::span(text)), seed);
  }
};

/// The channels of the sums part. Those of a pixel are in the order of Film::row_sums(), with the
/// counts of each replicate after its sums.
inline std::vector<std::string> sums_channels(const FilmLayout& layout) {
  std::vector<std::string> names;
  for (std::uint32_t r = 0; r < layout.replicates; ++r) {
    for (const std::string& channel : layout.channels)
      for (std::uint32_t limb = 0; limb < kSumLimbs; ++limb)
        names.push_back(fmt::format("r{}.{}.{}", r, channel, limb));
    for (std::uint32_t limb = 0; limb < kCountLimbs; ++limb) names.push_back(fmt::format("r{}.count.{}", r, limb));
  }
  return names;
}

}  // namespace eikon::exr
