// SPDX-License-Identifier: Apache-2.0
// Writes the parts of an EXR file, which OpenEXR reads. Its own writer deflates by zlib, which
// takes three times as long as libdeflate for the same size: a tenth of all processor time of a
// sequence of small frames.
#pragma once
#include <ImfHeader.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/atomic_file.h"

namespace eikon::exr {

/// Rows of a part that are written together. Numbers are words[channel * plane + (row - first) *
/// width + x]: floats as their bits, halves in the low bytes.
struct WordRows {
  int first = 0, last = 0;  // the last one is exclusive
  std::size_t width = 0, plane = 0;
  std::span<const std::string> channels;  // in the order of `words`
  std::span<const std::uint32_t> words;
};

/// A file of parts of scan lines, compressed by ZIP or RLE as their headers say.
class ScanlineFile {
 public:
  /// Writes the headers. throws InputError as AtomicFile; exceptions of OpenEXR for headers that it
  /// refuses
  ScanlineFile(AtomicFile& file, std::vector<Imf::Header> headers);
  /// Writes rows of a part. They follow the ones before, and are whole blocks of compression but
  /// for the last ones. throws InputError as AtomicFile
  void write(std::size_t part, const WordRows& rows);
  /// Writes where each block lies. To be called once all rows of all parts are written. throws
  /// InputError as AtomicFile
  void end();

 private:
  struct Part {
    Imf::Header header;
    std::size_t block_count = 0;
    std::vector<std::uint64_t> blocks{};  // positions in the file of those that are written
  };

  AtomicFile& file_;
  std::vector<Part> parts_;
  std::uint64_t table_ = 0;  // position of the blocks' positions
};

}  // namespace eikon::exr
