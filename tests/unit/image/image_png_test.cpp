// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>

#include "core/error.h"
#include "image/decode_picture.h"
#include "image/image.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::TemporaryFolder;

Image grey(std::uint32_t width, const std::vector<float>& values) {
  return {.width = width,
          .height = static_cast<std::uint32_t>(values.size()) / width,
          .channels = {"B", "G", "R"},
          .planes = {values, values, values},
          .metadata = {}};
}

/// R, G, B, and A if `has_alpha`, of all pixels; checks the width and the colour type that the file
/// states.
std::vector<int> read_png(const std::filesystem::path& path, std::uint32_t expected_width, bool has_alpha = false) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  const PictureHeader header = read_picture_header(bytes);
  EXPECT_EQ(header.format, PictureFormat::png);
  EXPECT_EQ(header.width, expected_width);
  EXPECT_EQ(bytes[25], has_alpha ? std::byte{6} : std::byte{2});  // colour type of IHDR: RGBA or RGB
  std::vector<int> codes;
  for (const std::uint32_t rgba : decode_picture(bytes, header))
    for (unsigned c = 0; c < (has_alpha ? 4U : 3U); ++c) codes.push_back(static_cast<int>(rgba >> 8 * c & 255));
  return codes;
}

TEST(Png, M25_every_srgb_code_comes_back) {
  const TemporaryFolder folder;
  std::vector<float> values;
  for (int code = 0; code < 256; ++code) {
    const double encoded = code / 255.0;
    values.push_back(
        static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4)));
  }
  write_png(folder / "a.png", grey(16, values), 0);
  const std::vector<int> codes = read_png(folder / "a.png", 16);
  for (std::size_t i = 0; i < 256; ++i) ASSERT_EQ(codes.at(3 * i), static_cast<int>(i));
}

TEST(Png, rounds_to_nearest_clamps_and_shows_what_is_not_finite_as_black) {
  const TemporaryFolder folder;
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  // 12.92 * 255 * v = 0.4 and 0.6 on the linear piece
  write_png(folder / "a.png", grey(8, {0.4f / 3294.6f, 0.6f / 3294.6f, 7.0f, -1.0f, inf, -inf, nan, 1.0f}), 0);
  const std::vector<int> codes = read_png(folder / "a.png", 8);
  const std::vector<int> expected{0, 1, 255, 0, 0, 0, 0, 255};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(codes.at(3 * i), expected[i]) << i;
}

TEST(Png, exposure_is_in_stops) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", grey(1, {0.25f}), 1);
  write_png(folder / "b.png", grey(1, {0.5f}), 0);
  write_png(folder / "c.png", grey(1, {8.0f}), -4);
  const auto a = read_png(folder / "a.png", 1);
  EXPECT_EQ(a, read_png(folder / "b.png", 1));
  EXPECT_EQ(a, read_png(folder / "c.png", 1));
}

TEST(Png, tones_are_mapped_after_exposure_and_before_srgb) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", grey(1, {2.0f}), -1, ToneMap::reinhard);  // 1 becomes 1/2
  write_png(folder / "b.png", grey(1, {0.5f}), 0);
  EXPECT_EQ(read_png(folder / "a.png", 1), read_png(folder / "b.png", 1));
}

// Half covered by linear 1/4 of its own: the EXR holds 1/8 and 1/2.
TEST(Png, with_alpha_has_colours_that_are_not_multiplied_by_it) {
  const TemporaryFolder folder;
  Image image = grey(4, {0.125f, 0.25f, 0.0f, 0.3f});
  image.channels.emplace_back("A");
  image.planes.push_back({0.5f, 1.0f, 0.0f, 1.25f});
  write_png(folder / "a.png", image, 0);
  const std::vector<int> codes = read_png(folder / "a.png", 4, true);
  const int quarter = 137;  // 255 (1.055 0.25^(1/2.4) - 0.055) = 136.96
  const std::vector<int> expected{quarter, quarter, quarter, 128, quarter, quarter, quarter, 255, 0, 0, 0, 0};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(codes.at(i), expected[i]) << i;
  EXPECT_EQ(codes.at(15), 255);  // a filter with negative parts goes beyond 1
}

TEST(Png, an_output_that_cannot_be_written_is_an_error_that_leaves_nothing_behind) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_png(folder / "missing" / "a.png", grey(1, {1}), 0), InputError);
  EXPECT_THROW(write_png(folder.path(), grey(1, {1}), 0), InputError);
  EXPECT_THROW(write_png("/dev/full", grey(1, {1}), 0), InputError);
  EXPECT_THROW(write_png(folder / "a.png", Image{}, 0), InputError);
  EXPECT_EQ(folder.file_count(), 0u);
}

}  // namespace
}  // namespace eikon
