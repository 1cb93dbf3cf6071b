// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfLineOrder.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "support/film_builder.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"
#include "support/fixed_point.h"

namespace eikon {
namespace {

using test::contains;
using test::message_of;
using test::random_film;
using test::read_bytes;
using test::small_layout;
using test::TemporaryFolder;

FilmLayout full_layout() {
  FilmLayout layout{.width = 40, .height = 50, .crop = {3, 7, 31, 44}, .replicates = 2};
  for (const char* name :
       {"albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z", "hits", "id"})
    layout.channels.emplace_back(name);
  return layout;
}

/// A film like a renderer's: every pixel has 4 samples, and a few of them hit nothing.
Film plausible_film() {
  const FilmLayout layout = full_layout();
  Film film(layout);
  for (std::uint32_t y = layout.crop.y0; y < layout.crop.y1; ++y)
    for (std::uint32_t x = layout.crop.x0; x < layout.crop.x1; ++x)
      for (std::uint32_t r = 0; r < 2; ++r) {
        film.set_count(x, y, r, 2);
        for (std::uint32_t c = 0; c < layout.channels.size(); ++c)
          film.set(x, y, r, c, to_fixed(std::sin(static_cast<float>(x + 3 * y + 7 * c + r)) + 1.0f));
        const float hits = x % 5 == 0 ? 0.0f : 1.0f;
        film.set(x, y, r, 9, to_fixed(hits * static_cast<float>(y)));
        film.set(x, y, r, 10, to_fixed(hits));
        film.set(x, y, r, 11, to_fixed(r == 0 ? static_cast<float>(x) + 1.0f : 0.0f));
      }
  return film;
}

/// Sums and counts are the same to the bit.
void expect_equal(const Film& found, const Film& expected) {
  const FilmLayout& layout = expected.layout();
  ASSERT_TRUE(found.layout() == layout);
  for (std::uint32_t y = layout.crop.y0; y < layout.crop.y1; ++y)
    for (std::uint32_t x = layout.crop.x0; x < layout.crop.x1; ++x)
      for (std::uint32_t r = 0; r < layout.replicates; ++r) {
        ASSERT_EQ(found.count(x, y, r), expected.count(x, y, r));
        for (std::uint32_t c = 0; c < layout.channels.size(); ++c)
          ASSERT_TRUE(found.sum(x, y, r, c) == expected.sum(x, y, r, c)) << x << ' ' << y << ' ' << r << ' ' << c;
      }
}

TEST(Exr, the_sums_part_restores_the_film_to_the_bit) {
  const TemporaryFolder folder;
  for (const std::uint32_t replicates : {1u, 2u, 8u}) {
    FilmLayout layout = full_layout();
    layout.replicates = replicates;
    const Film film = random_film(layout, replicates);
    write_exr(folder / "a.exr", film, {}, {.half = false, .layers = {}, .exact_sums = true});
    expect_equal(read_film(folder / "a.exr"), film);
  }
}

/// Writes all parts of a file anew, as other programs may.
void recompress(const std::filesystem::path& from, const std::filesystem::path& to, Imf::Compression compression,
                Imf::LineOrder order) {
  Imf::MultiPartInputFile in(from.c_str());
  std::vector<Imf::Header> headers;
  for (int part = 0; part < in.parts(); ++part) {
    headers.push_back(in.header(part));
    headers.back().compression() = compression;
    headers.back().lineOrder() = order;
  }
  Imf::MultiPartOutputFile out(to.c_str(), headers.data(), in.parts());
  for (int part = 0; part < in.parts(); ++part) {
    const Imath::Box2i window = headers[std::size_t(part)].dataWindow();
    const std::size_t width = std::size_t(window.size().x) + 1, height = std::size_t(window.size().y) + 1;
    std::vector<std::vector<std::uint32_t>> planes;
    Imf::FrameBuffer buffer;
    const Imf::ChannelList& channels = headers[std::size_t(part)].channels();
    for (auto i = channels.begin(); i != channels.end(); ++i) {
      planes.emplace_back(width * height);
      buffer.insert(i.name(), Imf::Slice::Make(i.channel().type, planes.back().data(), window, 4, 4 * width));
    }
    Imf::InputPart source(in, part);
    source.setFrameBuffer(buffer);
    source.readPixels(window.min.y, window.max.y);
    Imf::OutputPart target(out, part);
    target.setFrameBuffer(buffer);
    target.writePixels(int(height));
  }
}

TEST(Exr, sums_survive_a_program_that_writes_the_file_anew) {
  const TemporaryFolder folder;
  const Film film = random_film(full_layout(), 5);
  write_exr(folder / "a.exr", film, {}, {.half = false, .layers = {}, .exact_sums = true});
  // Chunks of 1, 16 and 32 rows, and lines from the bottom up.
  for (const auto compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION})
    for (const auto order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
      recompress(folder / "a.exr", folder / "b.exr", compression, order);
      SCOPED_TRACE(fmt::format("compression {}, order {}", int(compression), int(order)));
      expect_equal(read_film(folder / "b.exr"), film);
    }
}

TEST(Exr, the_picture_holds_the_means_and_the_layers_of_the_crop) {
  const TemporaryFolder folder;
  const Film film = plausible_film();
  write_exr(folder / "a.exr", film, {},
            {.half = false, .layers = {"albedo", "normal", "depth", "id", "variance", "samples"}, .exact_sums = true});
  const Image image = read_exr(folder / "a.exr");
  const Crop crop = film.layout().crop;
  ASSERT_EQ(image.width, crop.width());
  ASSERT_EQ(image.height, crop.height());
  ASSERT_EQ(image.channels.size(), 3u + 3 + 3 + 1 + 1 + 3 + 1);
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
      const std::size_t i = std::size_t{y - crop.y0} * crop.width() + (x - crop.x0);
      const auto value = [&](const char* channel) { return (*image.plane(channel))[i]; };
      ASSERT_EQ(value("G"), static_cast<float>(film.mean(x, y, 1)));
      ASSERT_EQ(value("albedo.B"), static_cast<float>(film.mean(x, y, 5)));
      ASSERT_EQ(value("normal.X"), static_cast<float>(film.mean(x, y, 6)));
      ASSERT_EQ(value("depth.Z"), x % 5 == 0 ? std::numeric_limits<float>::infinity() : static_cast<float>(y));
      ASSERT_EQ(value("id"), static_cast<float>(x + 1));
      ASSERT_EQ(value("variance.R"), static_cast<float>(film.variance_of_mean(x, y, 0)));
      ASSERT_EQ(value("samples"), 4.0f);
    }
  const Image means = to_image(film);
  EXPECT_EQ(means.planes[2], *image.plane("B"));
}

TEST(Exr, metadata_come_back) {
  const TemporaryFolder folder;
  Metadata metadata;
  metadata.strings = {
      {"scene", "cornell \"box\".gltf"}, {"empty", ""}, {"a.name.longer.than.thirty-one.characters", "x"}};
  metadata.numbers = {{"seconds", 1.0 / 3.0}, {"samples", 64}};
  metadata.matrices["worldToCamera"] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
  metadata.matrices["object"] = std::vector<double>(16, 0.5);
  write_exr(folder / "a.exr", plausible_film(), metadata, {});
  const Metadata back = read_metadata(folder / "a.exr");
  EXPECT_EQ(back.strings, metadata.strings);
  EXPECT_EQ(back.numbers, metadata.numbers);
  EXPECT_EQ(back.matrices, metadata.matrices);
  EXPECT_EQ(read_exr(folder / "a.exr").metadata.at("samples"), "64");
}

TEST(Exr, the_same_film_gives_the_same_bytes) {
  const TemporaryFolder folder;
  const ExrOptions options{.half = false, .layers = {"variance"}, .exact_sums = true};
  write_exr(folder / "a.exr", plausible_film(), {}, options);
  write_exr(folder / "b.exr", plausible_film(), {}, options);
  EXPECT_EQ(read_bytes(folder / "a.exr"), read_bytes(folder / "b.exr"));
}

TEST(Exr, half_rounds_and_refuses_what_would_become_infinite) {
  const TemporaryFolder folder;
  const FilmLayout layout = small_layout(2, 1, 1);
  Film film(layout);
  for (std::uint32_t x = 0; x < 2; ++x) film.set_count(x, 0, 0, 1);
  film.set(0, 0, 0, 1, to_fixed(65519.0f));
  film.set(1, 0, 0, 1, to_fixed(0.1f));
  write_exr(folder / "a.exr", film, {}, {.half = true, .layers = {}, .exact_sums = false});
  EXPECT_EQ(read_exr(folder / "a.exr").plane("G")->at(0), 65504.0f);
  EXPECT_NEAR(read_exr(folder / "a.exr").plane("G")->at(1), 0.1f, 0.1f / 2048);

  film.set(1, 0, 0, 2, to_fixed(-65520.0f));
  const std::string message =
      message_of([&] { write_exr(folder / "b.exr", film, {}, {.half = true, .layers = {}, .exact_sums = false}); });
  EXPECT_TRUE(contains(message, "1,0 in channel B"));
  EXPECT_EQ(folder.file_count(), 1u);  // a.exr: nothing half-written beside it
}

TEST(Exr, an_infinite_depth_is_no_reason_to_refuse_half) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", plausible_film(), {}, {.half = true, .layers = {"depth"}, .exact_sums = false});
  EXPECT_TRUE(std::isinf(read_exr(folder / "a.exr").plane("depth.Z")->at(2)));
}

TEST(Exr, an_output_that_cannot_be_written_is_an_error_that_leaves_nothing_behind) {
  const TemporaryFolder folder;
  const Film film = plausible_film();
  std::filesystem::create_directory(folder / "taken");
  EXPECT_THROW(write_exr(folder / "missing" / "a.exr", film, {}, {}), InputError);
  EXPECT_THROW(write_exr(folder / "taken", film, {}, {}), InputError);
  EXPECT_THROW(write_exr("/dev/full", film, {}, {}), InputError);
  EXPECT_THROW(write_exr(folder / (std::string(300, 'x') + ".exr"), film, {}, {}), InputError);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  EXPECT_EQ(folder.file_count(), 1u);  // the folder "taken"
}

TEST(Exr, a_full_disk_leaves_the_old_file_and_nothing_else) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.exr") << "old";
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  // The limit stops the header, the pixels, or the chunk table that OpenEXR writes last, in a
  // destructor that swallows errors.
  const Film film = plausible_film();
  write_exr(folder / "size.exr", film, {}, {});
  const auto size = std::filesystem::file_size(folder / "size.exr");
  for (const std::uintmax_t limit : {std::uintmax_t{10}, std::uintmax_t{700}, size / 2, size - 1}) {
    const rlimit small{.rlim_cur = limit, .rlim_max = before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(write_exr(folder / "a.exr", film, {}, {}), InputError) << limit;
    setrlimit(RLIMIT_FSIZE, &before);
  }
  EXPECT_EQ(read_bytes(folder / "a.exr"), "old");
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(Exr, a_link_stays_a_link) {
  const TemporaryFolder folder;
  std::ofstream(folder / "real.exr") << "old";
  std::filesystem::create_symlink("real.exr", folder / "link.exr");
  write_exr(folder / "link.exr", plausible_film(), {}, {});
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.exr"));
  EXPECT_EQ(read_exr(folder / "real.exr").width, 28u);
}

}  // namespace
}  // namespace eikon
