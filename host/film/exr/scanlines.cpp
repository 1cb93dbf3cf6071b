// SPDX-License-Identifier: Apache-2.0
// The layout of files is that of "OpenEXR File Layout" (openexr.com), and blocks are compressed as
// its ZIP and RLE say.
#include "film/exr/scanlines.h"

#include <ImfChannelList.h>
#include <ImfIO.h>
#include <ImfVersion.h>
#include <libdeflate.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

#include "core/error.h"

namespace eikon::exr {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

using Bytes = std::vector<std::uint8_t>;

constexpr int kDeflateLevel = 4;  // that of OpenEXR, since it has libdeflate

/// Bytes that are collected, since each write to a file takes several calls of the system.
class Collected : public Imf::OStream {
 public:
  Collected() : Imf::OStream("headers") {}
  void write(const char bytes[], int size) override { text_.append(bytes, static_cast<std::size_t>(size)); }
  std::uint64_t tellp() override { return text_.size(); }
  void seekp(std::uint64_t) override { throw InternalError("headers are written from their beginning to their end"); }

  void add(const auto& number) { text_.append(reinterpret_cast<const char*>(&number), sizeof number); }
  void add(const Bytes& bytes) { text_.append(bytes.begin(), bytes.end()); }
  void write_to(AtomicFile& file) const { file.write(text_.data(), text_.size()); }

 private:
  std::string text_;
};

int rows_of_block(const Imf::Header& header) { return header.compression() == Imf::ZIP_COMPRESSION ? 16 : 1; }

bool has_long_names(const Imf::Header& header) {
  constexpr std::size_t kShort = 31;
  for (auto i = header.begin(); i != header.end(); ++i)
    if (std::strlen(i.name()) > kShort || std::strlen(i.attribute().typeName()) > kShort) return true;
  for (auto i = header.channels().begin(); i != header.channels().end(); ++i)
    if (std::strlen(i.name()) > kShort) return true;
  return false;
}

/// The channels of the rows as the file has them, which is sorted by name: where their words are,
/// and their bytes each.
struct SortedChannel {
  const std::uint32_t* words;
  std::size_t bytes;
};

std::vector<SortedChannel> sorted_channels(const Imf::Header& header, const WordRows& rows) {
  std::vector<SortedChannel> sorted;
  for (auto i = header.channels().begin(); i != header.channels().end(); ++i) {
    const auto found = std::ranges::find(rows.channels, i.name());
    if (found == rows.channels.end()) throw InternalError("a channel of an EXR file has no numbers");
    const auto index = static_cast<std::size_t>(found - rows.channels.begin());
    sorted.push_back({&rows.words[index * rows.plane], i.channel().type == Imf::HALF ? 2U : 4U});
  }
  return sorted;
}

/// The bytes of some rows: row by row, channel by channel.
Bytes bytes_of(const std::vector<SortedChannel>& channels, const WordRows& rows, int first, int last) {
  std::size_t pixel_bytes = 0;
  for (const SortedChannel& channel : channels) pixel_bytes += channel.bytes;
  Bytes bytes(static_cast<std::size_t>(last - first) * rows.width * pixel_bytes);
  std::uint8_t* out = bytes.data();
  for (int row = first; row < last; ++row)
    for (const SortedChannel& channel : channels) {
      const std::uint32_t* const words = channel.words + static_cast<std::size_t>(row - rows.first) * rows.width;
      if (channel.bytes == sizeof(std::uint32_t)) {
        std::memcpy(out, words, rows.width * sizeof(std::uint32_t));
      } else {
        for (std::size_t x = 0; x < rows.width; ++x) {
          const auto half = static_cast<std::uint16_t>(words[x]);
          std::memcpy(out + 2 * x, &half, sizeof half);
        }
      }
      out += rows.width * channel.bytes;
    }
  return bytes;
}

/// Even bytes, then odd ones, each as the difference to the one before, plus 128: what both codecs
/// compress.
Bytes differences(const Bytes& bytes) {
  const std::size_t odd = bytes.size() / 2, even = bytes.size() - odd;
  Bytes split(bytes.size()), result(bytes.size());
  for (std::size_t i = 0; i < odd; ++i) split[i] = bytes[2 * i], split[even + i] = bytes[2 * i + 1];
  if (even > odd) split[odd] = bytes.back();
  result[0] = split[0];
  for (std::size_t i = 1; i < split.size(); ++i) result[i] = static_cast<std::uint8_t>(split[i] - split[i - 1] + 128);
  return result;
}

Bytes deflated(const Bytes& bytes) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kDeflateLevel), &libdeflate_free_compressor);
  if (compressor == nullptr) throw std::bad_alloc();
  Bytes out(bytes.size());  // what would be longer is of no use
  out.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

/// Runs of three and more as their length minus 1 and the byte; others as minus their number and
/// the bytes.
Bytes run_lengths(const Bytes& bytes) {
  constexpr std::ptrdiff_t kMinRun = 3, kMost = 127;
  Bytes out;
  out.reserve(bytes.size());
  const auto end = bytes.end();
  const auto run_at = [&](auto at) {
    const auto most = at + std::min<std::ptrdiff_t>(end - at, kMost + 1);
    return std::find_if(at + 1, most, [&](std::uint8_t byte) { return byte != *at; }) - at;
  };
  for (auto at = bytes.begin(); at != end;) {
    if (const std::ptrdiff_t run = run_at(at); run >= kMinRun) {
      out.push_back(static_cast<std::uint8_t>(run - 1));
      out.push_back(*at);
      at += run;
      continue;
    }
    auto to = at;
    while (to != end && to - at < kMost && !(end - to >= kMinRun && to[0] == to[1] && to[1] == to[2])) ++to;
    out.push_back(static_cast<std::uint8_t>(at - to));
    out.insert(out.end(), at, to);
    at = to;
  }
  return out;
}

/// A block as it lies in the file: as it is where compression gains nothing.
Bytes compressed(const Imf::Header& header, Bytes bytes) {
  const Bytes prepared = differences(bytes);
  Bytes packed = header.compression() == Imf::ZIP_COMPRESSION ? deflated(prepared) : run_lengths(prepared);
  return packed.empty() || packed.size() >= bytes.size() ? std::move(bytes) : std::move(packed);
}

}  // namespace

ScanlineFile::ScanlineFile(AtomicFile& file, std::vector<Imf::Header> headers) : file_(file) {
  const bool several = headers.size() > 1;
  int version = Imf::EXR_VERSION | (several ? Imf::MULTI_PART_FILE_FLAG : 0);
  for (Imf::Header& header : headers) {
    const int rows = header.dataWindow().max.y - header.dataWindow().min.y + 1, block = rows_of_block(header);
    const int blocks = (rows + block - 1) / block;
    if (several) header.setChunkCount(blocks);
    header.sanityCheck(false, several);
    if (has_long_names(header)) version |= Imf::LONG_NAMES_FLAG;
    parts_.push_back({std::move(header), static_cast<std::size_t>(blocks)});
  }
  Collected head;
  head.add(std::int32_t{Imf::MAGIC});
  head.add(std::int32_t{version});
  for (const Part& part : parts_) part.header.writeTo(head);
  if (several) head.add(std::uint8_t{0});
  table_ = file_.position() + head.tellp();
  for (const Part& part : parts_)
    for (std::size_t i = 0; i < part.block_count; ++i) head.add(std::uint64_t{0});
  head.write_to(file_);
}

void ScanlineFile::write(std::size_t index, const WordRows& rows) {
  Part& part = parts_[index];
  const std::vector<SortedChannel> channels = sorted_channels(part.header, rows);
  const int block = rows_of_block(part.header), count = (rows.last - rows.first + block - 1) / block;
  std::vector<Bytes> blocks(static_cast<std::size_t>(count));
  const auto first_of = [&](int i) { return rows.first + i * block; };
  tbb::parallel_for(0, count, [&](int i) {
    const int last = std::min(first_of(i + 1), rows.last);
    blocks[static_cast<std::size_t>(i)] = compressed(part.header, bytes_of(channels, rows, first_of(i), last));
  });
  Collected all;
  for (int i = 0; i < count; ++i) {
    const Bytes& bytes = blocks[static_cast<std::size_t>(i)];
    if (bytes.size() > std::size_t{std::numeric_limits<std::int32_t>::max()})
      throw InputError("a block of rows takes more than 2^31 bytes; write fewer layers at a time");
    part.blocks.push_back(file_.position() + all.tellp());
    if (parts_.size() > 1) all.add(static_cast<std::int32_t>(index));
    all.add(std::int32_t{first_of(i)});
    all.add(static_cast<std::int32_t>(bytes.size()));
    all.add(bytes);
  }
  all.write_to(file_);
}

void ScanlineFile::end() {
  const std::uint64_t end = file_.position();
  file_.seek(table_);
  for (const Part& part : parts_) {
    if (part.blocks.size() != part.block_count) throw InternalError("rows of an EXR file are missing");
    file_.write(part.blocks.data(), part.blocks.size() * sizeof part.blocks[0]);
  }
  file_.seek(end);
}

}  // namespace eikon::exr
