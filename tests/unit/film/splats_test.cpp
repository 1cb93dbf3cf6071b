// SPDX-License-Identifier: Apache-2.0
// What light paths bring to pixels: exact sums, which are divided by the number of light paths.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/error.h"
#include "film/exr/film_file.h"
#include "film/layers.h"
#include "shared/splat.h"
#include "support/film_builder.h"
#include "support/fixed_point.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::TemporaryFolder;
using test::UnitBuilder;

FilmLayout layout_with_splats(const Crop& crop = {0, 0, 4, 3}) {
  FilmLayout layout{.width = 4, .height = 3, .crop = crop, .replicates = 2};
  layout.channels = {"R", "G", "B", "scattered.1.R", "scattered.1.G", "scattered.1.B", "scattered.more.R",
                     "scattered.more.G", "scattered.more.B", "light.a.R", "light.a.G", "light.a.B",
                     "light.b.R", "light.b.G", "light.b.B"};
  const std::vector<std::string> splats = splat_channels_of(layout.channels);
  layout.channels.insert(layout.channels.end(), splats.begin(), splats.end());
  return layout;
}

struct Splat {
  std::uint32_t x, y, replicate, scatterings, group;
  std::array<float, 3> value;
};

std::vector<std::uint32_t> words_of(const std::vector<Splat>& splats) {
  std::vector<std::uint32_t> words;
  for (const Splat& s : splats) {
    words.push_back(s.x | s.y << 16);
    words.push_back(s.replicate | s.scatterings << 8 | s.group << 24);
    for (const float value : s.value) words.push_back(std::bit_cast<std::uint32_t>(value));
  }
  return words;
}

/// Adds a unit of pixel 0,0 without camera light, with these splats and so many light paths of each
/// of its samples.
void add_unit(Film& film, std::uint64_t begin, std::uint64_t end, const std::vector<Splat>& splats,
              std::uint64_t light_paths) {
  FilmLayout of_camera = film.layout();
  std::erase_if(of_camera.channels, [](const std::string& name) { return name.starts_with(kSplats); });
  const UnitBuilder unit(of_camera, {film.layout().crop.x0 | film.layout().crop.y0 << 16}, begin, end);
  UnitSums sums = unit.sums();
  const std::vector<std::uint32_t> words = words_of(splats);
  sums.splats = words;
  sums.light_paths = light_paths;
  film.add(sums);
}

TEST(Splats, are_sums_of_2_to_the_minus_48_rounded_down) {
  Film film(layout_with_splats());
  const std::vector<float> values = {1.5F,  -0.25F,  0x1p-64F, 0x1p-70F, -0x1p-70F, 0x1.fffffep53F,
                                     0.1F, 0x1p-149F, -0.1F,   -0x1p-149F, 0x1.234568p-41F, -0x1.abcdeep-50F};
  int128 expected = 0;
  for (const float value : values) {
    add_unit(film, 0, 1, {{2, 1, 0, 1, 0, {value, 0, 0}}}, 1);
    expected += int128(std::floor(std::ldexp(static_cast<long double>(value), 64 - kSplatShift)));
  }
  EXPECT_TRUE(film.sum(2, 1, 0, film.channel_index("splats.R").value()) == expected);
  EXPECT_TRUE(film.sum(2, 1, 0, 0) == 0) << "the camera's own sums stay as they are";
  EXPECT_EQ(film.samples(2, 1), 0U);
}

TEST(Splats, are_divided_by_the_light_paths_of_their_replicate_and_window) {
  Film film(layout_with_splats());
  // Samples 0 and 1, a replicate each.
  add_unit(film, 0, 2, {{1, 1, 0, 1, 0, {6, 0, 0}}, {1, 1, 1, 1, 0, {2, 0, 0}}}, 4);
  EXPECT_EQ(film.mean(1, 1, 0), 1.0) << "(6 + 2) over 8 light paths";
  EXPECT_EQ(film.mean(0, 1, 0), 0.0);
  film.set_count(1, 1, 0, 5), film.set_count(1, 1, 1, 5);
  film.set(1, 1, 0, 0, to_fixed(5.0F)), film.set(1, 1, 1, 0, to_fixed(10.0F));
  EXPECT_EQ(film.mean(1, 1, 0), 1.5 + 1.0);
  // Replicates have means 1 + 6 / 4 and 2 + 2 / 4, both 2.5: what they disagree about cancels.
  EXPECT_EQ(film.variance_of_mean(1, 1, 0), 0.0);
  add_unit(film, 2, 3, {}, 12);  // replicate 0 alone
  EXPECT_EQ(film.mean(1, 1, 0), 1.5 + 8.0 / 20);
  EXPECT_EQ(film.light_paths().front().paths, (std::vector<std::uint64_t>{16, 4}));
}

TEST(Splats, of_windows_count_in_their_windows) {
  Film film(layout_with_splats()), left(layout_with_splats({0, 0, 2, 3}));
  add_unit(film, 0, 2, {{1, 1, 0, 1, 0, {8, 0, 0}}, {3, 1, 0, 1, 0, {8, 0, 0}}}, 4);
  add_unit(left, 2, 4, {{1, 1, 0, 1, 0, {8, 0, 0}}}, 4);
  film.add(left);
  EXPECT_EQ(film.mean(1, 1, 0), 1.0) << "16 over 16";
  EXPECT_EQ(film.mean(3, 1, 0), 1.0) << "8 over 8";
  const Film row = film.rows(1, 2);
  EXPECT_EQ(row.mean(1, 1, 0), 1.0);
}

TEST(Splats, belong_to_a_bin_of_scatterings_and_to_a_light_group) {
  Film film(layout_with_splats());
  add_unit(film, 0, 1, {{0, 0, 0, 1, 0, {1, 0, 0}}, {0, 0, 0, 2, 1, {2, 0, 0}}, {0, 0, 0, 900, 1, {4, 0, 0}}}, 1);
  const auto mean = [&](const char* name) { return film.mean(0, 0, film.channel_index(name).value()); };
  EXPECT_EQ(mean("R"), 7.0);
  EXPECT_EQ(mean("scattered.1.R"), 1.0);
  EXPECT_EQ(mean("scattered.more.R"), 6.0);
  EXPECT_EQ(mean("light.a.R"), 1.0);
  EXPECT_EQ(mean("light.b.R"), 6.0);
  const Film once = scattered_at_most(film, 1);
  EXPECT_EQ(once.mean(0, 0, 0), 1.0);
}

TEST(Splats, survive_the_file_to_the_bit) {
  const TemporaryFolder folder;
  Film film(layout_with_splats());
  add_unit(film, 0, 2, {{1, 1, 0, 1, 0, {0.1F, 0.2F, 0.3F}}, {3, 2, 1, 2, 1, {5, 6, 7}}}, 3);
  Film left(layout_with_splats({0, 0, 2, 3}));
  add_unit(left, 2, 4, {{1, 1, 0, 1, 0, {8, 0, 0}}}, 4);
  film.add(left);
  write_exr(folder / "a.exr", film, {}, {.exact_sums = true});
  const Film back = read_film(folder / "a.exr");
  ASSERT_TRUE(back.layout() == film.layout());
  EXPECT_TRUE(std::ranges::equal(back.light_paths(), film.light_paths()));
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < 4; ++x) EXPECT_EQ(back.mean(x, y, 2), film.mean(x, y, 2));
}

TEST(Splats, that_do_not_fit_the_film_are_refused) {
  Film film(layout_with_splats());
  EXPECT_THROW(add_unit(film, 0, 1, {{9, 0, 0, 1, 0, {1, 0, 0}}}, 1), InternalError);
  EXPECT_THROW(add_unit(film, 0, 1, {{0, 0, 2, 1, 0, {1, 0, 0}}}, 1), InternalError);
  EXPECT_THROW(add_unit(film, 0, 1, {{0, 0, 0, 1, 2, {1, 0, 0}}}, 1), InternalError);
  Film plain(test::small_layout(4, 3));
  EXPECT_THROW(add_unit(plain, 0, 1, {{0, 0, 0, 1, 0, {1, 0, 0}}}, 1), InternalError);
}

}  // namespace
}  // namespace eikon
