// SPDX-License-Identifier: Apache-2.0
// The pixels of a film that a page gets.
#include "view/view_frame.h"

#include <gtest/gtest.h>

#include "page/page_picture.h"
#include "support/film_builder.h"

namespace eikon {
namespace {

constexpr std::uint32_t kWidth = 3, kHeight = 2;

/// Every channel has its index times 2^-4, times 1 + x at column x: two samples, of the same value.
Film ramp(const std::vector<std::string>& channels) {
  FilmLayout layout = test::small_layout(kWidth, kHeight);
  layout.channels = channels;
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) pixels.push_back(x | y << 16);
  test::UnitBuilder unit(layout, pixels, 0, 2);
  for (std::size_t p = 0; p < pixels.size(); ++p)
    for (std::size_t c = 0; c < channels.size(); ++c)
      for (const std::uint64_t sample : {0U, 1U}) unit.add(p, sample, c, int128{c * (1 + p % kWidth)} << 60);
  Film film(layout);
  film.add(unit.sums());
  return film;
}

/// The pixels that have such values at column 0, times 1 + x at column x.
std::vector<unsigned char> expected(double r, double g, double b) {
  std::vector<unsigned char> bytes;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const float scale = 1.0F + float(i % kWidth);
    append_rgbe(bytes, {float(r) * scale, float(g) * scale, float(b) * scale});
  }
  return bytes;
}

constexpr double kStep = 1.0 / 16;

TEST(ViewFrame, a_picture_is_radiance_and_a_layer_its_own_channels) {
  const Film film = ramp({"R", "G", "B", "albedo.R", "albedo.G", "albedo.B"});
  EXPECT_EQ(view_pixels(film, {}), expected(0, kStep, 2 * kStep));
  EXPECT_EQ(view_pixels(film, {.layer = "albedo"}), expected(3 * kStep, 4 * kStep, 5 * kStep));
}

TEST(ViewFrame, depth_is_the_mean_of_the_samples_that_hit) {
  const Film film = ramp({"R", "G", "B", "depth.Z", "hits"});
  const double depth = 3.0 / 4;  // both grow alike along a row
  std::vector<unsigned char> bytes;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) append_rgbe(bytes, {float(depth), float(depth), float(depth)});
  EXPECT_EQ(view_pixels(film, {.layer = "depth"}), bytes);
}

TEST(ViewFrame, light_groups_are_added_by_their_factors) {
  const Film film = ramp(
      {"R", "G", "B", "light.rest.R", "light.rest.G", "light.rest.B", "light.a.b.R", "light.a.b.G", "light.a.b.B"});
  EXPECT_EQ(view_pixels(film, {.layer = "lights"}), expected(9 * kStep, 11 * kStep, 13 * kStep));
  EXPECT_EQ(view_pixels(film, {.layer = "lights", .mix = {{"a.b", 0.5}}}), expected(6 * kStep, 7.5 * kStep, 9 * kStep));
  EXPECT_EQ(view_pixels(film, {.layer = "lights", .mix = {{"a.b", 0}, {"rest", 2}}}),
            expected(6 * kStep, 8 * kStep, 10 * kStep));
}

TEST(ViewFrame, the_denoised_layer_is_the_picture_until_there_is_one_without_noise) {
  const Film film = ramp({"R", "G", "B", "albedo.R", "albedo.G", "albedo.B"});
  EXPECT_EQ(view_pixels(film, {.layer = "denoised"}), view_pixels(film, {}));
  Image picture{
      .width = kWidth, .height = kHeight, .channels = {"albedo.R", "B", "G", "R"}, .planes = {}, .metadata = {}};
  for (const double value : {9.0, 2 * kStep, kStep, 0.0}) {
    std::vector<float>& plane = picture.planes.emplace_back();
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) plane.push_back(float(value * (1 + i % kWidth)));
  }
  EXPECT_EQ(view_pixels(picture), expected(0, kStep, 2 * kStep));
}

TEST(ViewFrame, samples_that_agree_have_no_error) {
  EXPECT_EQ(view_pixels(ramp({"R", "G", "B"}), {.layer = "error"}), expected(0, 0, 0));
}

}  // namespace
}  // namespace eikon
