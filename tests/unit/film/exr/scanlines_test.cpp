// SPDX-License-Identifier: Apache-2.0
// What ScanlineFile writes, read by OpenEXR.
#include "film/exr/scanlines.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace eikon::exr {
namespace {

using test::TemporaryFolder;

constexpr int kLeft = -3, kTop = 5;  // of the data window

struct Picture {
  Imf::Header header;
  std::vector<std::string> channels{"wide", "half",
                                    "a name of more than thirty-one letters"};  // not in the file's order
  std::size_t width = 0;
  int rows = 0;
  std::vector<std::uint32_t> words;

  Picture(const char* name, Imf::Compression compression, std::size_t columns, int height)
      : header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(99, 99)),
               Imath::Box2i(Imath::V2i(kLeft, kTop), Imath::V2i(kLeft + int(columns) - 1, kTop + height - 1))),
        width(columns),
        rows(height),
        words(channels.size() * columns * std::size_t(height)) {
    header.compression() = compression;
    header.setName(name);
    header.setType("scanlineimage");
    header.insert("note", Imf::StringAttribute("kept"));
    for (std::size_t c = 0; c < channels.size(); ++c)
      header.channels().insert(channels[c], Imf::Channel(c == 1 ? Imf::HALF : c == 0 ? Imf::UINT : Imf::FLOAT));
  }

  /// Runs of the same word, of lengths around those at which the codecs change, and words like none
  /// before.
  void fill(unsigned seed) {
    std::mt19937 random(seed);
    for (std::size_t i = 0; i < words.size();) {
      static constexpr std::array<std::size_t, 8> kLengths{1, 2, 3, 4, 127, 128, 129, 300};
      const std::size_t length = seed % 3 == 0 ? 1 : kLengths[random() % kLengths.size()];
      const auto word = std::uint32_t(random());
      for (std::size_t k = 0; k < length && i < words.size(); ++k, ++i) words[i] = word;
    }
    const std::size_t plane = words.size() / channels.size();  // halves lie in the low bytes
    for (std::size_t i = plane; i < 2 * plane; ++i) words[i] &= 0xffffU;
  }

  void write(ScanlineFile& file, std::size_t part) const {
    const int most = 32;  // two blocks of ZIP
    const std::size_t plane = width * std::size_t(rows);
    for (int first = 0; first < rows; first += most) {
      const std::span<const std::uint32_t> from = std::span(words).subspan(width * std::size_t(first));
      file.write(part, {.first = kTop + first,
                        .last = kTop + std::min(first + most, rows),
                        .width = width,
                        .plane = plane,
                        .channels = channels,
                        .words = from});
    }
  }

  void expect_in(Imf::MultiPartInputFile& file, int index) const {
    Imf::InputPart part(file, index);
    EXPECT_EQ(part.header().typedAttribute<Imf::StringAttribute>("note").value(), "kept");
    std::vector<std::uint32_t> found(words.size());
    Imf::FrameBuffer buffer;
    const std::size_t plane = width * std::size_t(rows);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const Imf::Channel* const channel = part.header().channels().findChannel(channels[c]);
      ASSERT_NE(channel, nullptr);
      buffer.insert(channels[c], Imf::Slice::Make(channel->type, &found[c * plane], header.dataWindow(), 4, 4 * width));
    }
    part.setFrameBuffer(buffer);
    part.readPixels(kTop, kTop + rows - 1);
    EXPECT_EQ(found, words);
  }
};

/// A file of these pictures, each in a part.
void write_file(const std::filesystem::path& path, const std::vector<Picture>& pictures) {
  std::vector<Imf::Header> headers;
  for (const Picture& picture : pictures) headers.push_back(picture.header);
  AtomicFile file(path);
  ScanlineFile parts(file, headers);
  for (std::size_t i = 0; i < pictures.size(); ++i) pictures[i].write(parts, i);
  parts.end();
  file.commit();
}

TEST(Scanlines, openexr_reads_them_to_the_bit) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.exr";
  for (unsigned seed = 0; seed < 12; ++seed)
    for (const Imf::Compression compression : {Imf::ZIP_COMPRESSION, Imf::RLE_COMPRESSION}) {
      Picture picture("alone", compression, 1 + 13 * (seed % 4), 1 + 9 * int(seed));
      picture.fill(seed);
      write_file(path, {picture});
      Imf::MultiPartInputFile file(path.c_str());
      ASSERT_EQ(file.parts(), 1);
      picture.expect_in(file, 0);
    }
}

TEST(Scanlines, parts_of_different_sizes_and_codecs_share_a_file) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.exr";
  Picture first("first", Imf::ZIP_COMPRESSION, 40, 70), second("second", Imf::RLE_COMPRESSION, 7, 3);
  first.fill(1), second.fill(2);
  write_file(path, {first, second});
  Imf::MultiPartInputFile file(path.c_str());
  ASSERT_EQ(file.parts(), 2);
  first.expect_in(file, 0);
  second.expect_in(file, 1);
}

TEST(Scanlines, what_repeats_is_compressed_and_what_does_not_takes_no_more_than_its_bytes) {
  const TemporaryFolder folder;
  for (const Imf::Compression compression : {Imf::ZIP_COMPRESSION, Imf::RLE_COMPRESSION}) {
    for (const bool repeats : {true, false}) {
      Picture picture("alone", compression, 200, 64);
      if (!repeats) picture.fill(3);
      AtomicFile file(folder / "a.exr");
      ScanlineFile parts(file, {picture.header});
      const std::uint64_t head = file.position();
      picture.write(parts, 0);
      const std::uint64_t bytes = file.position() - head, raw = 200 * 64 * (4 + 2 + 4), around = 64 * 8;
      if (repeats)
        EXPECT_LT(bytes, raw / 20 + around);
      else
        EXPECT_LE(bytes, raw + around);
    }
  }
}

TEST(Scanlines, a_file_without_all_of_its_rows_is_not_ended) {
  const TemporaryFolder folder;
  const Picture picture("alone", Imf::ZIP_COMPRESSION, 8, 40);
  AtomicFile file(folder / "a.exr");
  ScanlineFile parts(file, {picture.header});
  EXPECT_THROW(parts.end(), InternalError);
}

}  // namespace
}  // namespace eikon::exr
