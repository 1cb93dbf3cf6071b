// SPDX-License-Identifier: Apache-2.0
// 8-bit pictures: every kind of PNG and JPEG comes out as RGBA, and files that lie are refused.
#include <gtest/gtest.h>

#include <array>
#include <span>

#include "core/error.h"
#include "support/picture_builder.h"
#include "unit/image/decoded_picture.h"

namespace eikon {
namespace {

using picture_test::bytes_of;
using picture_test::decoded;
using picture_test::jpeg;
using picture_test::JpegKind;
using picture_test::plain_png;
using picture_test::png;
using picture_test::PngOptions;
using picture_test::refusal;
using picture_test::Samples;
using picture_test::with_png_size;
using test::contains;

constexpr std::uint32_t rgba(std::uint32_t r, std::uint32_t g, std::uint32_t b, std::uint32_t a = 255) {
  return r | g << 8U | b << 16U | a << 24U;
}

TEST(DecodePng, every_colour_type_becomes_rgba) {
  using Pixels = std::vector<std::uint32_t>;
  const Samples rgb{1, 2, 3, 255, 0, 128};
  EXPECT_EQ(decoded(png(2, 1, rgb)), (Pixels{rgba(1, 2, 3), rgba(255, 0, 128)}));
  EXPECT_EQ(decoded(png(1, 2, rgb)), (Pixels{rgba(1, 2, 3), rgba(255, 0, 128)}));
  EXPECT_EQ(decoded(png(2, 1, {1, 2, 3, 4, 5, 6, 7, 0}, {.colour_type = PNG_COLOR_TYPE_RGB_ALPHA})),
            (Pixels{rgba(1, 2, 3, 4), rgba(5, 6, 7, 0)}));
  EXPECT_EQ(decoded(png(2, 1, {9, 200}, {.colour_type = PNG_COLOR_TYPE_GRAY})),
            (Pixels{rgba(9, 9, 9), rgba(200, 200, 200)}));
  EXPECT_EQ(decoded(png(2, 1, {9, 8, 200, 0}, {.colour_type = PNG_COLOR_TYPE_GRAY_ALPHA})),
            (Pixels{rgba(9, 9, 9, 8), rgba(200, 200, 200, 0)}));
  EXPECT_EQ(decoded(png(4, 1, {0b00011011}, {.colour_type = PNG_COLOR_TYPE_GRAY, .depth = 2})),
            (Pixels{rgba(0, 0, 0), rgba(85, 85, 85), rgba(170, 170, 170), rgba(255, 255, 255)}));
  EXPECT_EQ(decoded(png(2, 1, {9, 200}, {.colour_type = PNG_COLOR_TYPE_GRAY, .transparent = {200}})),
            (Pixels{rgba(9, 9, 9), rgba(200, 200, 200, 0)}));
  EXPECT_EQ(decoded(png(2, 1, rgb, {.transparent = {1, 2, 3}})), (Pixels{rgba(1, 2, 3, 0), rgba(255, 0, 128)}));
  const PngOptions palette{.colour_type = PNG_COLOR_TYPE_PALETTE,
                           .depth = 4,
                           .palette = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}},
                           .palette_alpha = {10, 20}};
  EXPECT_EQ(decoded(png(3, 1, {0x01, 0x20}, palette)), (Pixels{rgba(1, 2, 3, 10), rgba(4, 5, 6, 20), rgba(7, 8, 9)}));
}

TEST(DecodePng, sixteen_bits_are_rounded_to_eight_and_said) {
  // v / 257 to nearest: 128 -> 0, 129 -> 1, 65535 -> 255.
  const std::string file = png(1, 1, {0x00, 0x80, 0x00, 0x81, 0xFF, 0xFF}, {.depth = 16});
  EXPECT_TRUE(read_picture_header(bytes_of(file)).deep);
  EXPECT_EQ(decoded(file), std::vector<std::uint32_t>{rgba(0, 1, 255)});
  EXPECT_FALSE(read_picture_header(bytes_of(plain_png(1, 1))).deep);
}

TEST(DecodePng, interlacing_and_gamma_change_nothing) {
  Samples rows;
  for (int i = 0; i < 3 * 13 * 11; ++i) rows.push_back(static_cast<std::uint8_t>(i * 7));
  const auto expected = decoded(png(13, 11, rows));
  EXPECT_EQ(decoded(png(13, 11, rows, {.interlaced = true})), expected);
  EXPECT_EQ(decoded(png(13, 11, rows, {.gamma = 1.0})), expected);
  EXPECT_EQ(decoded(png(13, 11, rows, {.gamma = 0.25})), expected);
}

TEST(DecodePng, a_size_that_so_few_bytes_cannot_hold_is_refused_before_memory_is_taken) {
  const std::string small = plain_png(4, 4);
  for (const auto& [width, height] : {std::pair{0x7FFFFFFFU, 0x7FFFFFFFU},
                                      {0xFFFFFFFFU, 0xFFFFFFFFU},
                                      {16384U, 16384U},
                                      {1U, 0x7FFFFFFFU},
                                      {0x7FFFFFFFU, 1U}}) {
    EXPECT_TRUE(contains(refusal(with_png_size(small, width, height)), "cannot hold")) << width << ' ' << height;
  }
  refusal(with_png_size(small, 0, 4));
  refusal(with_png_size(small, 4, 0));
  // Large enough a file for the claim, but beyond what is read at all.
  const std::string padded = with_png_size(small, 20000, 20000) + std::string(std::size_t{3} << 20U, 'x');
  EXPECT_TRUE(contains(refusal(padded), "more than"));
}

TEST(DecodePng, a_bomb_of_zeros_is_refused_by_its_size) {
  // 32768 x 32768 grey pixels of 1 bit: 128 MiB of zeros in 130 kB; 4 GiB as RGBA.
  const std::uint32_t side = 32768;
  const std::string bomb = png(side, side, Samples(std::size_t{side} * side / 8), {.colour_type = 0, .depth = 1});
  ASSERT_LT(bomb.size(), 200000U);
  EXPECT_TRUE(contains(refusal(bomb), "32768 x 32768"));
}

TEST(DecodePng, a_file_cut_anywhere_is_an_error) {
  Samples rows;
  for (int i = 0; i < 3 * 13 * 11; ++i) rows.push_back(static_cast<std::uint8_t>(i * i));
  const std::string good = png(13, 11, rows);
  ASSERT_LT(good.size(), 2000U);
  for (std::size_t size = 0; size < good.size(); ++size) refusal(good.substr(0, size));
}

template <typename Check>
void change_bytes(const std::string& good, Check check) {
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const int value : {0x00, 0x01, 0x7F, 0x80, 0xFF}) {
      std::string changed = good;
      changed[at] = static_cast<char>(value);
      try {
        const PictureHeader header = read_picture_header(bytes_of(changed));
        check(header, decode_picture(bytes_of(changed), header));
      } catch (const InputError& e) {
        ASSERT_FALSE(contains(e.what(), "\n"));
      }
    }
  }
}

TEST(DecodePng, changed_bytes_give_a_picture_or_an_error) {
  Samples rows;
  for (int i = 0; i < 13 * 11; ++i) rows.push_back(static_cast<std::uint8_t>(i % 3));
  const std::string good = png(13, 11, rows,
                               {.colour_type = PNG_COLOR_TYPE_PALETTE,
                                .interlaced = true,
                                .palette = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}},
                                .palette_alpha = {10, 20}});
  change_bytes(good, [](const PictureHeader& header, const std::vector<std::uint32_t>& pixels) {
    ASSERT_EQ(pixels.size(), std::size_t{header.width} * header.height);
  });
}

Samples ramp(std::size_t count) {
  Samples samples;
  for (std::size_t i = 0; i < count; ++i) samples.push_back(static_cast<std::uint8_t>(i * 255 / count));
  return samples;
}

TEST(DecodeJpeg, grey_and_colour_baseline_and_progressive_become_rgba) {
  const Samples grey = ramp(20 * 10);
  for (const JpegKind kind : {JpegKind::baseline, JpegKind::progressive}) {
    const auto pixels = decoded(jpeg(20, 10, 1, grey, kind));
    ASSERT_EQ(pixels.size(), 200U);
    for (std::size_t i = 0; i < 200; ++i) {
      EXPECT_EQ(pixels[i] >> 24U, 255U);
      EXPECT_EQ(pixels[i] & 0xFFU, pixels[i] >> 8U & 0xFFU);
      EXPECT_NEAR(static_cast<double>(pixels[i] & 0xFFU), grey[i], 3) << i;
    }
    Samples orange;
    for (int i = 0; i < 256; ++i) orange.insert(orange.end(), {200, 100, 50});
    for (const std::uint32_t pixel : decoded(jpeg(16, 16, 3, orange, kind))) {
      EXPECT_NEAR(pixel & 0xFFU, 200, 2);
      EXPECT_NEAR(pixel >> 8U & 0xFFU, 100, 2);
      EXPECT_NEAR(pixel >> 16U & 0xFFU, 50, 2);
      EXPECT_EQ(pixel >> 24U, 255U);
    }
  }
}

// Adobe's files hold 255 - ink, in CMYK or in YCCK. What is left of light is (1 - ink) (1 - black).
TEST(DecodeJpeg, inks_become_the_light_that_they_leave) {
  Samples stored;
  for (int i = 0; i < 256; ++i) stored.insert(stored.end(), {255, 128, 64, 204});
  const struct {
    JpegKind kind;
    double r, g, b;
  } rows[] = {{JpegKind::baseline, 204, 102.4, 51.2},
              {JpegKind::progressive, 204, 102.4, 51.2},
              {JpegKind::ycck, 204, 102.4, 51.2},
              {JpegKind::unmarked, 0, 25.4, 38.2}};
  for (const auto& row : rows) {
    for (const std::uint32_t pixel : decoded(jpeg(16, 16, 4, stored, row.kind))) {
      ASSERT_NEAR(pixel & 0xFFU, row.r, 2);
      ASSERT_NEAR(pixel >> 8U & 0xFFU, row.g, 2);
      ASSERT_NEAR(pixel >> 16U & 0xFFU, row.b, 2);
      ASSERT_EQ(pixel >> 24U, 255U);
    }
  }
}

/// Another size in the frame header of a JPEG.
std::string with_jpeg_size(std::string file, std::uint32_t width, std::uint32_t height) {
  std::size_t frame = file.find("\xFF\xC0");
  if (frame == std::string::npos) frame = file.find("\xFF\xC2");
  for (std::size_t i = 0; i < 2; ++i) {
    file[frame + 5 + i] = static_cast<char>(height >> (8 - 8 * i));
    file[frame + 7 + i] = static_cast<char>(width >> (8 - 8 * i));
  }
  return file;
}

TEST(DecodeJpeg, sizes_that_lie_are_refused_before_memory_is_taken) {
  const std::string small = jpeg(16, 16, 3, ramp(768));
  EXPECT_TRUE(contains(refusal(with_jpeg_size(small, 65500, 65500)), "cannot hold"));
  EXPECT_TRUE(contains(refusal(with_jpeg_size(small, 16, 0)), "size"));
  EXPECT_TRUE(contains(refusal(with_jpeg_size(small, 0, 16)), "size"));
  refusal(with_jpeg_size(small, 100, 100));  // more than its data are for
  const std::string padded = with_jpeg_size(small, 65500, 65500) + std::string(std::size_t{5} << 20U, 'x');
  EXPECT_TRUE(contains(refusal(padded), "more than"));
  const std::size_t scan = small.find("\xFF\xDA");
  EXPECT_TRUE(contains(refusal(with_jpeg_size(small, 65500, 65500).substr(0, scan)), "cannot hold"));
}

TEST(DecodeJpeg, kinds_that_are_not_read_are_named) {
  std::string file = jpeg(8, 8, 1, ramp(64));
  const std::size_t frame = file.find("\xFF\xC0");
  file[frame + 4] = 12;
  EXPECT_TRUE(contains(refusal(file), "12 bits per channel"));
  file[frame + 1] = '\xC3';
  EXPECT_TRUE(contains(refusal(file), "lossless or hierarchical"));
}

TEST(DecodeJpeg, a_file_cut_anywhere_is_an_error) {
  for (const JpegKind kind : {JpegKind::baseline, JpegKind::progressive}) {
    const std::string good = jpeg(40, 24, 3, ramp(std::size_t{3} * 40 * 24), kind);
    ASSERT_LT(good.size(), 8000U);
    for (std::size_t size = 0; size < good.size(); ++size) refusal(good.substr(0, size));
  }
}

TEST(DecodeJpeg, changed_bytes_give_a_picture_or_an_error) {
  for (const JpegKind kind : {JpegKind::baseline, JpegKind::progressive}) {
    change_bytes(jpeg(24, 16, 3, ramp(std::size_t{3} * 24 * 16), kind),
                 [](const PictureHeader& header, const std::vector<std::uint32_t>& pixels) {
                   ASSERT_EQ(pixels.size(), std::size_t{header.width} * header.height);
                 });
  }
}

TEST(DecodeJpeg, hundreds_of_scans_are_refused) {
  // Each visits every pixel, so that a small file could take hours.
  EXPECT_TRUE(contains(refusal(jpeg(64, 64, 1, ramp(4096), JpegKind::hundreds_of_scans)), "scans"));
}

TEST(DecodePicture, formats_are_told_by_their_first_bytes) {
  const std::array<std::pair<std::string, PictureFormat>, 9> files{
      {{plain_png(1, 1), PictureFormat::png},
       {jpeg(8, 8, 1, ramp(64)), PictureFormat::jpeg},
       {"\xABKTX 20\xBB\r\n\x1A\n", PictureFormat::ktx2},
       {"RIFF....WEBPVP8 ", PictureFormat::webp},
       {std::string("\0\0\0\x1C", 4) + "ftypavif", PictureFormat::avif},
       {"GIF89a", PictureFormat::gif},
       {"", PictureFormat::unknown},
       {"RIFF", PictureFormat::unknown},
       {"hello", PictureFormat::unknown}}};
  for (const auto& [file, format] : files) EXPECT_EQ(picture_format(bytes_of(file)), format);
  EXPECT_TRUE(contains(refusal("GIF89a"), "neither PNG, JPEG, WebP nor KTX2"));
}

}  // namespace
}  // namespace eikon
