// SPDX-License-Identifier: Apache-2.0
// Mattes of renders: what each sample meets, counted without error however the work is cut.
#include "film/mattes.h"

#include <algorithm>
#include <map>

#include "render/scene_builder.h"
#include "render/ways_to_shade.h"

namespace eikon::test {
namespace {

std::pair<Scene, Settings> matted(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  auto both = room(width, height, spp);
  both.second.aovs = {"cryptomatte_material", "cryptomatte_object", "object_id"};
  return both;
}

TEST(Mattes, count_every_sample_by_the_name_of_what_it_meets) {
  const auto [scene, settings] = matted(40, 30, 16);
  const Film film = film_of(scene, settings);
  ASSERT_EQ(film.layout().mattes, (std::vector<std::string>{"cryptomatte_object", "cryptomatte_material"}));
  std::map<std::uint32_t, std::string> names{{0, "nothing"}};
  for (const Node& node : scene.nodes) names[matte_id(node.name)] = node.name;
  const std::uint32_t id = film.channel_index("id").value();
  std::map<std::string, int> seen;
  int edges = 0;
  for (std::uint32_t y = 0; y < 30; ++y)
    for (std::uint32_t x = 0; x < 40; ++x) {
      const std::vector<MatteCount> objects = film.matte(0, x, y);
      std::uint64_t all = 0;
      for (const MatteCount& count : objects) {
        all += count.samples;
        ASSERT_TRUE(names.contains(count.id));
        seen[names.at(count.id)] += int(count.samples);
      }
      EXPECT_EQ(all, 16U);
      // Each node of the room has a material of its own name.
      EXPECT_EQ(film.matte(1, x, y), objects);
      // The pixel's first sample is one of those.
      const auto number = std::size_t(film.total(x, y, id) >> 64);
      const std::uint32_t first = number == 0 ? 0 : matte_id(scene.nodes[number - 1].name);
      EXPECT_NE(std::ranges::find(objects, first, &MatteCount::id), objects.end());
      edges += objects.size() > 1 ? 1 : 0;
    }
  EXPECT_GT(edges, 40);
  for (const auto& [node, name] : names) EXPECT_GT(seen[name], 0) << name;
}

TEST(Mattes, of_a_half_covered_pixel_have_half_of_its_samples) {
  // The edge of the square runs through the middle of a column of pixels: samples are stratified,
  // so a pixel's 64 are cut in half to within one of each of the two replicates' nets.
  Scene scene;
  Primitive half;
  add_quad(half, {0, -50, -2}, {50, 0, 0}, {0, 100, 0});
  add_mesh(scene, "half", std::move(half), lambert(0.5F));
  Settings settings = settings_for(9, 9, 64);
  settings.aovs = {"cryptomatte_object"};
  const Film film = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 9; ++y) {
    const std::vector<MatteCount> middle = film.matte(0, 4, y);
    ASSERT_EQ(middle.size(), 2U);
    EXPECT_NEAR(double(middle[1].samples), 32, 2) << y;
    EXPECT_EQ(film.matte(0, 3, y), (std::vector<MatteCount>{{0, 64}}));
    EXPECT_EQ(film.matte(0, 5, y), (std::vector<MatteCount>{{matte_id("half"), 64}}));
  }
}

TEST(Mattes, have_the_same_counts_on_every_way_to_trace_and_in_units_of_any_size) {
  const auto [scene, settings] = matted(33, 21, 5);
  const Film expected = film_of(scene, settings);
  for (const Execution& execution : ways_to_shade())
    EXPECT_TRUE(same_film(film_of(scene, settings, execution), expected)) << describe(execution);
  Execution small;
  small.unit_paths = 1U << 10;
  small.block = 7;
  EXPECT_TRUE(same_film(film_of(scene, settings, small), expected));
  Execution two;
  two.devices = "cpu:2x1";
  const RenderOutput output = output_of(scene, settings, two);
  EXPECT_EQ(output.report.devices.size(), 2U);
  EXPECT_TRUE(same_film(output.film, expected));
}

TEST(Mattes, change_no_bit_of_the_picture_and_windows_and_ranges_add_up_to_the_whole) {
  auto [scene, settings] = matted(24, 18, 9);
  const Film whole = film_of(scene, settings);
  Film sum(whole.layout());
  for (const auto& [crop, begin, end] : {std::tuple{Crop{0, 0, 24, 18}, 0, 2},
                                         {Crop{0, 0, 11, 18}, 2, 9},
                                         {Crop{11, 0, 24, 18}, 2, 3},
                                         {Crop{11, 0, 24, 18}, 3, 9}}) {
    Settings part = settings;
    part.crop = crop;
    part.sample_begin = std::uint64_t(begin), part.sample_end = std::uint64_t(end);
    sum.add(film_of(scene, part));
  }
  EXPECT_TRUE(same_film(sum, whole));
  settings.aovs = {"object_id"};
  const Film plain = film_of(scene, settings);
  EXPECT_TRUE(plain.layout().mattes.empty());
  for (std::uint32_t i = 0; i < 24 * 18; ++i)
    for (std::uint32_t c = 0; c < whole.layout().channels.size(); ++c)
      ASSERT_EQ(whole.total(i % 24, i / 24, c), plain.total(i % 24, i / 24, c));
}

TEST(Mattes, see_through_opacity_by_its_share) {
  Scene scene;
  Primitive front, back;
  add_quad(front, {-5, -5, -2}, {10, 0, 0}, {0, 10, 0});
  add_quad(back, {-5, -5, -3}, {10, 0, 0}, {0, 10, 0});
  Material veil = lambert(0.5F);
  veil.alpha_mode = AlphaMode::blend;
  veil.opacity = 0.25F;
  add_mesh(scene, "veil", std::move(front), veil);
  add_mesh(scene, "wall", std::move(back), lambert(0.5F));
  Settings settings = settings_for(16, 16, 64);
  settings.aovs = {"cryptomatte_object"};
  const Film film = film_of(scene, settings);
  double veiled = 0;
  for (std::uint32_t i = 0; i < 256; ++i)
    for (const MatteCount& count : film.matte(0, i % 16, i / 16))
      veiled += count.id == matte_id("veil") ? double(count.samples) : 0;
  // Binomial at worst; decisions are stratified.
  EXPECT_NEAR(veiled / (256 * 64), 0.25, 4 * std::sqrt(0.25 * 0.75 / (256 * 64)));
}

}  // namespace
}  // namespace eikon::test
