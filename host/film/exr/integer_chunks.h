// SPDX-License-Identifier: Apache-2.0
// Reads the integer channels of a scan line part, a chunk at a time, by OpenEXR's C interface: sums
// have dozens of channels, for which Imf::InputPart takes three times as long.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "film/film.h"

namespace eikon::exr {

/// Rows of a part.
struct IntegerChunk {
  std::uint32_t first_row = 0, rows = 0;
  /// words[channel * words_per_channel + (row - first_row) * width + x - x0], with channels in the
  /// order in which they were asked for. It is valid until the next chunk is read.
  const std::uint32_t* words = nullptr;
  std::size_t words_per_channel = 0;
};

class IntegerChunks {
 public:
  /// path      of a file that Reader has checked
  /// part      a scan line part
  /// window    its data window
  /// channels  of type UINT that the part has
  /// throws std::exception, as OpenEXR's classes do, when the file is damaged
  IntegerChunks(const std::filesystem::path& path, int part, const Crop& window,
                const std::vector<std::string>& channels);
  ~IntegerChunks();
  IntegerChunks(const IntegerChunks&) = delete;
  IntegerChunks& operator=(const IntegerChunks&) = delete;

  /// The chunk that begins at this row of the data window. throws std::exception when the file is
  /// damaged
  [[nodiscard]] IntegerChunk read(std::uint32_t row);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon::exr
