// SPDX-License-Identifier: Apache-2.0
// Files that lie: each reader call ends in an image or in an InputError of one line.
#include <gtest/gtest.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>

#include <array>
#include <bit>

#include "core/error.h"
#include "support/film_builder.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::contains;
using test::error_of;
using test::message_of;
using test::read_bytes;
using test::small_layout;
using test::TemporaryFolder;

/// Calls a reader; anything but an image or an InputError of one line fails the test.
template <typename Reader>
bool reads(Reader reader, const std::filesystem::path& path) {
  const std::string refusal = error_of([&] { static_cast<void>(reader(path)); });
  if (refusal.empty()) return true;
  EXPECT_TRUE(contains(refusal, path.filename().string()));
  return false;
}

/// A small file with both parts, whose sums are noise and so do not compress.
std::string small_file(const TemporaryFolder& folder) {
  FilmLayout layout = small_layout(9, 20);
  layout.crop = {2, 1, 8, 19};
  Metadata metadata;
  metadata.strings["scene"] = "box.gltf";
  metadata.numbers["seconds"] = 1.5;
  write_exr(folder / "small.exr", test::random_film(layout, 1), metadata,
            {.half = false, .layers = {"variance", "samples"}, .exact_sums = true});
  return read_bytes(folder / "small.exr");
}

TEST(HostileExr, a_file_cut_anywhere_is_an_input_error) {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder);
  ASSERT_LT(bytes.size(), 40'000u);
  const auto path = folder / "cut.exr";
  // Every byte of the headers and chunk tables, then every 61st of the pixels.
  for (std::size_t size = 0; size < bytes.size(); size += size < 4000 ? 1 : 61) {
    folder.write(path.filename(), bytes.substr(0, size));
    ASSERT_FALSE(reads(read_film, path)) << size;
    if (size % 8 == 0) reads(read_exr, path);
    if (size % 8 == 4) reads(read_metadata, path);
  }
  folder.write(path.filename(), bytes.substr(0, bytes.size() - 1));
  EXPECT_FALSE(reads(read_film, path));
}

TEST(HostileExr, changed_bytes_never_crash_a_reader) {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder);
  std::mt19937 random(2);
  const auto path = folder / "changed.exr";
  int refused = 0;
  for (int run = 0; run < 600; ++run) {
    std::string changed = bytes;
    // Two of three changes hit the headers, where the sizes are.
    for (std::uint32_t flips = 1 + static_cast<std::uint32_t>(random()) % 3; flips > 0; --flips)
      changed[random() % (run % 3 == 0 ? changed.size() : 2500)] = static_cast<char>(random());
    folder.write(path.filename(), changed);
    refused += reads(read_film, path) ? 0 : 1;
    reads(read_exr, path);
    reads(read_metadata, path);
  }
  EXPECT_GT(refused, 100);
}

TEST(HostileExr, a_huge_window_is_refused_before_memory_is_taken) {
  const TemporaryFolder folder;
  const std::string bytes = small_file(folder);
  for (const std::int32_t side : {60'000, 70'000, 2'000'000'000, -5}) {
    std::string changed = bytes;
    for (std::size_t at = 0; (at = changed.find("dataWindow", at)) != std::string::npos; ++at) {
      // "dataWindow" 0 "box2i" 0, size, then x_min y_min x_max y_max
      const std::size_t x_max = at + 11 + 6 + 4 + 8;
      const auto word = std::bit_cast<std::array<char, 4>>(side);
      for (std::size_t i = 0; i < 4; ++i) changed[x_max + i] = changed[x_max + 4 + i] = word[i];
    }
    folder.write("huge.exr", changed);
    EXPECT_FALSE(reads(read_exr, folder / "huge.exr")) << side;
    EXPECT_FALSE(reads(read_film, folder / "huge.exr")) << side;
  }
}

TEST(HostileExr, a_channel_that_is_listed_twice_is_refused) {
  const TemporaryFolder folder;
  FilmLayout layout = small_layout(9, 20);
  layout.channels = {"R", "G", "B", "Q"};
  write_exr(folder / "four.exr", test::random_film(layout, 1), {}, {.exact_sums = true});
  EXPECT_TRUE(reads(read_film, folder / "four.exr"));
  std::string bytes = read_bytes(folder / "four.exr");
  const std::size_t at = bytes.find("R,G,B,Q");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 6] = 'B';
  folder.write("twice.exr", bytes);
  EXPECT_THROW(read_film(folder / "twice.exr"), InputError);
}

TEST(HostileExr, what_is_no_exr_is_named) {
  const TemporaryFolder folder;
  folder.write("text.exr", "not an image at all");
  folder.write("empty.exr", "");
  folder.write("magic.exr", "\x76\x2f\x31\x01");
  for (const auto& [name, says] :
       {std::pair("text.exr", "no OpenEXR file"), std::pair("empty.exr", "is empty (0 bytes)"),
        std::pair("magic.exr", "cut off or damaged: copy or render it again"),
        std::pair("missing.exr", "no such file; check the name"), std::pair(".", "is a directory")}) {
    EXPECT_THROW(read_film(folder / name), InputError) << name;
    EXPECT_TRUE(contains(message_of([&, &file = name] { (void)read_exr(folder / file); }), says)) << name;
  }
}

TEST(HostileExr, a_plain_picture_is_no_film) {
  const TemporaryFolder folder;
  Film film(small_layout(2, 2));
  write_exr(folder / "plain.exr", film, {}, {});
  EXPECT_TRUE(contains(message_of([&] { read_film(folder / "plain.exr"); }), "plain picture"));
}

/// R as half, G as float, B as uint, with a data window that does not begin at 0.
Imf::Header foreign_header() {
  Imf::Header header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(99, 99)),
                     Imath::Box2i(Imath::V2i(-3, 5), Imath::V2i(16, 24)));
  header.channels().insert("R", Imf::Channel(Imf::HALF));
  header.channels().insert("G", Imf::Channel(Imf::FLOAT));
  header.channels().insert("B", Imf::Channel(Imf::UINT));
  return header;
}

struct ForeignPixels {
  std::vector<half> r = std::vector<half>(400);
  std::vector<float> g = std::vector<float>(400);
  std::vector<unsigned> b = std::vector<unsigned>(400);
  Imf::FrameBuffer buffer;

  ForeignPixels() {
    for (unsigned i = 0; i < 400; ++i)
      r[i] = half(0.5f * static_cast<float>(i)), g[i] = -0.1f * static_cast<float>(i), b[i] = i;
    const Imath::Box2i window = foreign_header().dataWindow();
    buffer.insert("R", Imf::Slice::Make(Imf::HALF, r.data(), window));
    buffer.insert("G", Imf::Slice::Make(Imf::FLOAT, g.data(), window));
    buffer.insert("B", Imf::Slice::Make(Imf::UINT, b.data(), window));
  }
};

void expect_foreign_pixels(const Image& image) {
  ASSERT_EQ(image.width, 20u);
  ASSERT_EQ(image.height, 20u);
  for (unsigned i = 0; i < 400; ++i) {
    ASSERT_EQ((*image.plane("R"))[i], 0.5f * static_cast<float>(i));
    ASSERT_EQ((*image.plane("G"))[i], -0.1f * static_cast<float>(i));
    ASSERT_EQ((*image.plane("B"))[i], static_cast<float>(i));
  }
}

TEST(Exr, files_of_other_programs_are_read_whatever_their_layout_type_and_compression) {
  const TemporaryFolder folder;
  const auto path = folder / "foreign.exr";
  const ForeignPixels pixels;
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    Imf::Header header = foreign_header();
    header.compression() = compression;
    {
      Imf::OutputFile file(path.c_str(), header);
      file.setFrameBuffer(pixels.buffer);
      file.writePixels(20);
    }
    expect_foreign_pixels(read_exr(path));
    header.setTileDescription(Imf::TileDescription(7, 9, Imf::MIPMAP_LEVELS));
    {
      Imf::TiledOutputFile file(path.c_str(), header);
      file.setFrameBuffer(pixels.buffer);
      file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
      // Levels below 0 are smaller and fit into the same buffer.
      for (int level = 1; level < file.numLevels(); ++level)
        file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
    expect_foreign_pixels(read_exr(path));
    // The same tiled file with bytes changed.
    const std::string bytes = read_bytes(path);
    std::mt19937 random(3);
    for (int run = 0; run < 60; ++run) {
      std::string changed = bytes;
      changed[random() % (run % 2 == 0 ? changed.size() : 400)] = static_cast<char>(random());
      folder.write("changed.exr", changed);
      reads(read_exr, folder / "changed.exr");
    }
  }
}

TEST(HostileExr, a_subsampled_channel_is_refused_by_name) {
  const TemporaryFolder folder;
  const auto path = folder / "subsampled.exr";
  {
    Imf::Header header(16, 16);
    header.channels().insert("RY", Imf::Channel(Imf::FLOAT, 2, 2));
    std::vector<float> values(64);
    Imf::FrameBuffer buffer;
    buffer.insert("RY", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 4 * 8, 2, 2));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(16);
  }
  EXPECT_FALSE(reads(read_exr, path));
}

}  // namespace
}  // namespace eikon
