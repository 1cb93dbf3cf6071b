// SPDX-License-Identifier: Apache-2.0
#include "render/film_record.h"

#include "render/pilot/pilot.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/film_builder.h"
#include "film/exr/film_file.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::contains;
using test::error_of;
using test::random_film;
using test::small_layout;
using test::TemporaryFolder;

WorkUnit part(const Crop& block, std::uint64_t begin, std::uint64_t end) {
  WorkUnit unit;
  unit.block = block;
  unit.sample_begin = begin;
  unit.sample_end = end;
  return unit;
}

struct Image9x7 {
  Scene scene;
  Settings settings;
  FilmLayout layout = small_layout(9, 7);
  Image9x7() {
    scene.hash = "0123456789abcdef";
    settings.width = 9;
    settings.height = 7;
    settings.crop = layout.crop;
  }
  [[nodiscard]] std::vector<ImageSetting> described() const { return image_settings(scene, settings, layout); }
};

FilmRecord some_record() {
  FilmRecord record;
  record.settings = Image9x7().described();
  record.arithmetic = {"exact", "other-12345678"};
  record.light_path_counts = {4800};
  record.guiding = {"0123456789abcdef", "off"};
  record.layers = {"albedo", "variance"};
  record.sample_set.add(part({0, 0, 9, 4}, 0, 12));
  record.sample_set.add(part({2, 4, 7, 7}, 3, std::uint64_t{1} << 40));
  return record;
}

std::string refusal(const std::string& text) {
  return error_of([&] { static_cast<void>(parse_film_record(text, small_layout(9, 7))); });
}

TEST(FilmRecord, says_so_where_samples_are_guided_in_several_ways) {
  FilmState begin{Film(small_layout(9, 7)), SampleSet()};
  PilotReport guided, left_out;
  guided.guiding_paths = left_out.guiding_paths = 4096;
  guided.roulette_depth = 2;
  guided.guiding_digest = 0x1234;
  std::vector<std::string> notes;
  agree_on_pilot(begin, Settings(), PilotReport(), notes);  // of an image without a pilot
  EXPECT_TRUE(begin.guiding.empty());
  for (int again = 0; again < 2; ++again) agree_on_pilot(begin, Settings(), guided, notes);
  EXPECT_EQ(begin.guiding, std::set<std::string>{"0000000000001234"});
  EXPECT_TRUE(notes.empty());
  agree_on_pilot(begin, Settings(), left_out, notes);  // as where a device has no memory for the table
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(contains(notes[0], "no bias, but other bits"));
  EXPECT_EQ(note_of_guiding(begin.guiding), notes[0]);
}

TEST(FilmRecord, comes_back_from_its_text) {
  const FilmRecord record = some_record();
  EXPECT_TRUE(parse_film_record(to_text(record), small_layout(9, 7)) == record);
}

TEST(FilmRecord, every_setting_of_the_image_counts_and_nothing_else_does) {
  const std::vector<ImageSetting> usual = Image9x7().described();
  EXPECT_FALSE(difference(usual, Image9x7().described()));
  const auto changed = [&](const auto& change) {
    Image9x7 image;
    change(image);
    return difference(usual, image.described()).value_or("");
  };
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.seed = 7; }), "its seed (--seed) is 7, not 0");
  EXPECT_NE(changed([](Image9x7& i) { i.scene.hash = "f123456789abcdef"; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.width = 10; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.replicate_bits = 3; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.max_depth = 5; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.roulette_depth = 5; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.light_sampling = LightSampling::bsdf; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.transparent = true; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.filter.width = 1.0000001; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.yfov_rad = std::nextafter(0.7, 1); }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.projection = Projection::orthographic; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.projection = Projection::panorama; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.lens = Lens{.radius_m = 1e-9}; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.world_from_camera[0][2] = 1e-17; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.camera.world_from_camera[3][1] = 1e-17; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.environment.radiance.y = 1e-20F; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.layout.channels.emplace_back("id"); }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.pilot_paths = 1U << 15; }), "");
  EXPECT_NE(changed([](Image9x7& i) { i.settings.light_path_count = 1; }), "");
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.light_trial_paths = 16384; }),
            "its light paths (--light-paths) is auto, by 16384 paths, not none");
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.merges_caustics = true; }),
            "its caustics (--caustics) is merge, not unbiased");
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.crop = {1, 1, 2, 2}; }), "");
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.sample_end = 1000; }), "");
  EXPECT_EQ(changed([](Image9x7& i) { i.settings.camera.name = "another"; }), "");
  EXPECT_TRUE(difference(usual, {}));
}

TEST(FilmRecord, culling_guiding_light_paths_and_caustics_count_and_files_that_do_not_name_them_have_none) {
  Image9x7 culled;
  culled.settings.culling = Culling::camera;
  FilmRecord record = some_record();
  std::string text = to_text(record);
  for (const std::string line : {"setting culling (--cull): none\n", "setting guiding (--guiding): off\n",
                                 "setting light paths (--light-paths): none\n",
                                 "setting caustics (--caustics): unbiased\n"}) {
    const std::size_t at = text.find(line);
    ASSERT_NE(at, std::string::npos);
    text.erase(at, line.size());
  }
  EXPECT_TRUE(parse_film_record(text, small_layout(9, 7)) == record);
  record.settings = culled.described();
  EXPECT_TRUE(parse_film_record(to_text(record), small_layout(9, 7)) == record);
  EXPECT_EQ(difference(culled.described(), Image9x7().described()), "its culling (--cull) is none, not camera");
}

TEST(FilmRecord, the_pixels_of_a_map_count_and_not_its_name) {
  const auto with_map = [](const std::string& name, float blue, double rotation) {
    auto map = std::make_shared<EnvironmentMap>();
    map->name = name;
    map->width = 2;
    map->height = 1;
    map->radiance = {{1, 2, 3}, {4, 5, blue}};
    Image9x7 image;
    image.settings.environment.map = map;
    image.settings.environment.rotation_rad = rotation;
    return image.described();
  };
  EXPECT_FALSE(difference(with_map("a.exr", 6, 0), with_map("b.exr", 6, 0)));
  EXPECT_TRUE(difference(with_map("a.exr", 6, 0), with_map("a.exr", 6.0000005F, 0)));
  EXPECT_TRUE(difference(with_map("a.exr", 6, 0), with_map("a.exr", 6, 1e-9)));
}

TEST(FilmRecord, text_that_makes_no_sense_is_refused) {
  for (const char* text : {"part 0 0 9 7 0\n", "part 0 0 9 7 0 4 1\n", "part 0 0 9 7 4 4\n", "part 0 0 10 7 0 4\n",
                           "part 3 0 3 7 0 4\n", "part 0 0 9 7 0 281474976710657\n", "part 0 0 9 7 -1 4\n",
                           "part  0 0 9 7 0 4\n", "part 0 0 9 7 0 4 \n", "part 0 0 9 7 0 99999999999999999999\n",
                           "part 0 0 9 7 0 4\npart 8 6 9 7 3 5\n", "part 0 0 9 7 0 4", "setting x\n", "\n", "what\n"})
    EXPECT_NE(refusal(text), "") << text;
  EXPECT_EQ(refusal("part 0 0 9 7 0 4\npart 8 6 9 7 4 5\n"), "");
}

// A file whose sums are read must be the one that was written: no change of a byte goes through
// unseen.
TEST(FilmRecord, no_changed_byte_and_no_missing_one_gives_other_sums) {
  const TemporaryFolder folder;
  FilmLayout layout{.width = 9, .height = 7, .crop = {0, 0, 9, 7}, .replicates = 2};
  const Film film = random_film(layout, 4);
  const std::string record = to_text(some_record());
  for (const bool quick : {false, true}) {
    ExrOptions options;
    options.exact_sums = true;
    options.record = record;
    options.quick = quick;
    write_exr(folder / "a.exr", film, {}, options);
    const std::string whole = test::read_bytes(folder / "a.exr");
    int refused = 0;
    const auto check = [&](const std::string& bytes, std::size_t at) {
      folder.write("b.exr", bytes);
      try {
        SumsReader reader(folder / "b.exr");
        Film back(reader.layout());
        reader.add_to(back);
        ASSERT_EQ(reader.record(), record) << at;
        ASSERT_TRUE(reader.layout() == layout) << at;
        for (std::uint32_t y = 0; y < 7; ++y) {
          const auto a = back.row_sums(y), b = film.row_sums(y);
          ASSERT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << at;
          const auto c = back.row_counts(y), d = film.row_counts(y);
          ASSERT_TRUE(std::equal(c.begin(), c.end(), d.begin(), d.end())) << at;
        }
      } catch (const InputError& error) {
        ++refused;
        EXPECT_FALSE(contains(error.what(), "\n"));
      }
    };
    for (std::size_t at = 0; at < whole.size(); at += quick ? 2 : 7) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
      check(changed, at);
    }
    EXPECT_GT(refused, 100);
    refused = 0;
    int cuts = 0;
    for (std::size_t size = 0; size < whole.size(); size += 61, ++cuts) check(whole.substr(0, size), size);
    EXPECT_EQ(refused, cuts);
  }
}

TEST(FilmRecord, sums_larger_than_128_bits_can_hold_are_refused) {
  const TemporaryFolder folder;
  const FilmLayout layout = small_layout(2, 1);
  Film film(layout);
  const int128 most = static_cast<int128>(~static_cast<unsigned __int128>(0) >> 2);  // of one replicate
  film.set(1, 0, 1, 2, most);
  ExrOptions options;
  options.exact_sums = true;
  write_exr(folder / "a.exr", film, {}, options);
  Film sum = read_film(folder / "a.exr");
  EXPECT_THROW(SumsReader(folder / "a.exr").add_to(sum), InputError);
}

}  // namespace
}  // namespace eikon
