// SPDX-License-Identifier: Apache-2.0
// Stores the counts of a film's mattes beside its sums. The part of the file is a table, not a
// picture: it has an entry for each matte, pixel and id, in this order, so that the same counts
// give the same bytes. Its channels are "matte", "pixel" (of the crop, row by row), "id", "count.0"
// and "count.1" (low word first). Entries run along the rows, and zeros follow the last one.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>
#include <ImfHeader.h>

#include "image/exr_file.h"
#include "film/exr/scanlines.h"
#include "film/film.h"

namespace eikon::exr {

/// seal  the checksum of the sums that these counts belong to
[[nodiscard]] Imf::Header mattes_header(const Film& film, Imf::Header like, const std::string& seal);
/// part  that of mattes_header(), of which `header` is the header
void write_mattes(ScanlineFile& file, std::size_t part, const Imf::Header& header, const Film& film);

/// Adds the counts to a film whose crop contains that of `layout`. throws InputError when they are
/// damaged or missing, or belong to other sums; the film is then unusable
void read_mattes(const std::filesystem::path& path, Reader& reader, const FilmLayout& layout, const std::string& seal,
                 Film& film);

/// Ranks the ids of each pixel by their share of the samples, largest first (smaller id first among
/// equals). Samples that miss have no id but count, so the shares may add up to less than 1.
class MatteRanks {
 public:
  static constexpr std::size_t kRanks = 6, kChannels = 2 * kRanks;
  /// The film must outlive this.
  MatteRanks(const Film& film, std::size_t matte) : film_(film), matte_(matte) {}
  /// Channel 2 r is the id of rank r, as a float of the same bits; channel 2 r + 1 is its share.
  /// Rows are ranked a few at a time, so calls should go along rows.
  [[nodiscard]] float value(std::uint32_t x, std::uint32_t y, std::size_t channel);

 private:
  static constexpr std::uint32_t kRows = 16;
  using Ranks = std::array<float, kChannels>;
  const Film& film_;
  std::size_t matte_;
  std::vector<Ranks> block_;  // ranks of rows [begin_, end_)
  std::uint32_t begin_ = 0, end_ = 0;
  [[nodiscard]] Ranks ranks(std::uint32_t x, std::uint32_t y) const;
};

/// The channel names "LAYER00.R", ..., in the order of MatteRanks::value().
[[nodiscard]] std::vector<std::string> matte_channels(const std::string& layer);
/// The attributes of the header: "cryptomatte/<key>/name" and so on.
[[nodiscard]] std::map<std::string, std::string> matte_attributes(const std::string& layer,
                                                                  const std::string& manifest);

}  // namespace eikon::exr
