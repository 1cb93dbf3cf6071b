// SPDX-License-Identifier: Apache-2.0
// Light paths bring the same bits by any way of tracing and in any parts, and each layer gets its
// own.
#include "render/lights/light_path_scenes.h"

namespace eikon::test {
namespace {

void expect_the_same_bits_of_light_paths(const Scene& scene, Settings settings) {
  settings = with_light_paths(settings, 0.3);
  settings.aovs = {"direct", "indirect"};
  const Film expected = film_of(scene, settings);
  expect_the_same_bits_by_every_way(scene, settings, expected);
  const Film in_small_units = film_of(scene, settings, small_units());
  EXPECT_EQ(in_small_units.light_paths().front().paths, expected.light_paths().front().paths);
}

TEST(LightPathBits, are_the_same_by_every_way_of_tracing) {
  const auto [room, settings] = room_of_glass(20, 6);
  expect_the_same_bits_of_light_paths(room, settings);
  const auto [floor, sunny] = floor_in_the_sun(20, 6, 300);
  expect_the_same_bits_of_light_paths(floor, sunny);
}

TEST(LightPathBits, of_parts_add_up_to_those_of_the_whole) {
  auto [scene, settings] = room_of_glass(20, 6);
  settings = with_light_paths(settings, 0.3);
  const Film expected = film_of(scene, settings);
  Film by_samples(expected.layout());
  for (const auto& [begin, end] : {std::pair(0, 1), std::pair(1, 4), std::pair(4, 6)}) {
    Settings part = settings;
    part.sample_begin = std::uint64_t(begin), part.sample_end = std::uint64_t(end);
    by_samples.add(film_of(scene, part));
  }
  EXPECT_TRUE(same_film(by_samples, expected));
  EXPECT_EQ(by_samples.mean(3, 4, 0), expected.mean(3, 4, 0));
  Film by_windows(expected.layout());
  for (const Crop& window : {Crop{0, 0, 20, 9}, Crop{0, 9, 13, 20}, Crop{13, 9, 20, 20}}) {
    Settings part = settings;
    part.crop = window;
    by_windows.add(film_of(scene, part));
  }
  EXPECT_TRUE(same_film(by_windows, expected));
  for (std::uint32_t y = 0; y < 20; ++y)
    for (std::uint32_t x = 0; x < 20; ++x) EXPECT_EQ(by_windows.mean(x, y, 1), expected.mean(x, y, 1)) << x << ' ' << y;
}

TEST(LightPathBits, belong_to_the_layers_of_their_light) {
  const auto [scene, settings] = room_of_glass(16, 32);
  expect_depths_add_up(scene, with_light_paths(settings, 0.5), 1e-9);
}

}  // namespace
}  // namespace eikon::test
