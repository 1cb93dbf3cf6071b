// SPDX-License-Identifier: Apache-2.0
#include "film/mattes.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <random>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "support/film_builder.h"
#include "film/exr/film_file.h"
#include "film/units.h"
#include "image/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::contains;
using test::small_layout;
using test::TemporaryFolder;

TEST(Mattes, ids_are_those_of_the_reference_implementation) {
  // From the tests of Cryptomatte's reference implementation, nuke/cryptomatte_utilities_tests.py,
  // CryptoHashing.
  const std::pair<const char*, double> known[] = {
      {"hello", 6.0705627102400005616e-17},
      {"cube", -4.08461912519e+15},
      {"sphere", 2.79018604383e+15},
      {"plane", 3.66557617593e-11},
      {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0", -1.3192631212399999468e-25},
      {"m\xc3\xa4"
       "dchen",
       6.2361298211599995797e+25}};
  // As many digits as that file has, which for some names are fewer than a float's.
  for (const auto& [name, id] : known) {
    const double found = double(std::bit_cast<float>(matte_id(name)));
    EXPECT_NEAR(found, id, 1e-11 * std::abs(id) + 0x1p-24 * std::abs(id)) << name;
    EXPECT_EQ(float(found), float(id)) << name;
  }
  // MurmurHash3_32 of nothing is 0, which as a float is denormal: bit 23 is turned.
  EXPECT_EQ(matte_id(""), 0x00800000U);
}

TEST(Mattes, ids_are_normal_numbers_whatever_the_name) {
  int turned = 0;
  for (int i = 0; i < 20000; ++i) {
    const float id = std::bit_cast<float>(matte_id(fmt::format("object {}", i)));
    ASSERT_TRUE(std::isnormal(id)) << i;
    const std::uint32_t exponent = std::bit_cast<std::uint32_t>(id) >> 23U & 0xffU;
    turned += exponent == 1 || exponent == 254 ? 1 : 0;
  }
  // Exponents 0, 1, 254 and 255 of 256 end there.
  EXPECT_NEAR(turned, 20000 * 4 / 256.0, 5 * std::sqrt(20000 * 4 / 256.0));
}

TEST(Mattes, manifests_say_every_name_once_in_utf8) {
  Scene scene;
  scene.nodes.resize(4);
  scene.nodes[0].name = "a \"quoted\"\nname";
  scene.nodes[1].name = "\xff";  // no UTF-8
  scene.nodes[2].name = scene.nodes[0].name;
  scene.nodes[3].name = "node 3";
  const Mattes mattes = make_mattes(scene, {"albedo", "cryptomatte_object"});
  ASSERT_EQ(mattes.layers, std::vector<std::string>{"cryptomatte_object"});
  ASSERT_EQ(mattes.ids.at(0).size(), 5U);
  EXPECT_EQ(mattes.ids[0][0], 0U);
  EXPECT_EQ(mattes.ids[0][1], mattes.ids[0][3]);
  const std::string& text = mattes.manifests.at("cryptomatte_object");
  EXPECT_FALSE(contains(text, "\n"));
  const auto manifest = nlohmann::json::parse(text);
  EXPECT_EQ(manifest.size(), 3U);
  for (const auto& [name, id] : manifest.items()) EXPECT_EQ(id, matte_hex(matte_id(name)));
  EXPECT_TRUE(manifest.contains("node 3"));
}

TEST(MatteCounts, are_the_same_in_any_order_and_grow_with_ids_alone) {
  MatteCounts forwards(3, 2), backwards(3, 2);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    forwards.add(i % 3, i / 3 % 2, {i * i % 7, i});
    const std::uint32_t k = 999 - i;
    backwards.add(k % 3, k / 3 % 2, {k * k % 7, k});
  }
  std::uint64_t all = 0;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::vector<MatteCount> counts = forwards.of(i % 3, i / 3);
    EXPECT_EQ(counts, backwards.of(i % 3, i / 3));
    EXPECT_LE(counts.size(), 4U);  // squares modulo 7
    EXPECT_TRUE(std::ranges::is_sorted(counts, {}, &MatteCount::id));
    for (const MatteCount& count : counts) all += count.samples;
  }
  EXPECT_EQ(all, 999U * 1000U / 2);
  MatteCounts full(1, 1);
  full.add(0, 0, {5, ~std::uint64_t{0}});
  EXPECT_THROW(full.add(0, 0, {5, 1}), InputError);
}

TEST(MatteCounts, of_a_pixel_with_very_many_ids_are_read_in_their_order_at_once) {
  constexpr std::uint32_t kIds = 1 << 20;
  MatteCounts counts(2, 1);
  for (int time = 0; time < 2; ++time)  // the second part of an image adds to the first
    for (std::uint32_t id = 0; id < kIds; ++id)
      counts.add(1, 0, {id, 1});  // for hours, if each had to pass those before
  const std::vector<MatteCount> all = counts.of(1, 0);
  ASSERT_EQ(all.size(), kIds);
  for (std::uint32_t id = 0; id < kIds; ++id) ASSERT_EQ(all[id], (MatteCount{id, 2}));
  EXPECT_TRUE(counts.of(0, 0).empty());
}

TEST(MatteCounts, are_those_of_a_map_in_random_order) {
  MatteCounts counts(3, 1);
  std::array<std::map<std::uint32_t, std::uint64_t>, 3> expected;
  std::mt19937 random(5);
  for (int i = 0; i < 20000; ++i) {
    const auto x = static_cast<std::uint32_t>(random() % 3), id = static_cast<std::uint32_t>(random() % 500);
    counts.add(x, 0, {id, random() % 4});
  }
  random.seed(5);
  for (int i = 0; i < 20000; ++i) {
    const auto x = random() % 3;
    const auto id = static_cast<std::uint32_t>(random() % 500);
    if (const std::uint64_t samples = random() % 4; samples > 0) expected[x][id] += samples;
  }
  for (std::uint32_t x = 0; x < 3; ++x) {
    std::vector<MatteCount> wanted;
    for (const auto& [id, samples] : expected[x]) wanted.push_back({id, samples});
    EXPECT_EQ(counts.of(x, 0), wanted);
  }
}

FilmLayout matte_layout() {
  FilmLayout layout{.width = 40, .height = 30, .crop = {3, 5, 31, 24}, .replicates = 2};
  layout.mattes = {"cryptomatte_object", "cryptomatte_material"};
  return layout;
}

/// Up to nine ids in a pixel, one of them nothing.
Film matte_film(const FilmLayout& layout, std::uint32_t seed) {
  Film film(layout);
  for (std::uint32_t y = layout.crop.y0; y < layout.crop.y1; ++y)
    for (std::uint32_t x = layout.crop.x0; x < layout.crop.x1; ++x) {
      film.set_count(x, y, 0, 1);
      for (std::uint32_t m = 0; m < 2; ++m)
        for (std::uint32_t k = 0; k <= (x * y + seed) % 9; ++k)
          film.add_to_matte(m, x, y, {k == 0 ? 0 : matte_id(fmt::format("{} {}", m, k)), x + y * k + seed});
    }
  return film;
}

bool same_mattes(const Film& a, const Film& b) {
  const Crop& crop = a.layout().crop;
  if (!(a.layout() == b.layout())) return false;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::size_t m = 0; m < 2; ++m)
        if (a.matte(m, x, y) != b.matte(m, x, y)) return false;
  return true;
}

TEST(Mattes, a_unit_of_many_pixels_and_samples_counts_each_number_once) {
  // So many that several threads add them, in tiles that the crop cuts, and with runs of equal
  // numbers.
  const Crop crop = {3, 5, 260, 70};
  FilmLayout layout = small_layout(300, 80);
  layout.crop = crop;
  layout.mattes = {"cryptomatte_object", "cryptomatte_material"};
  const std::vector<std::uint32_t> pixels = unit_pixels(crop);
  constexpr std::uint64_t kSamples = 40;
  const std::vector<std::vector<std::uint32_t>> ids = {{0, 70, 20, 90}, {0, 5, 4}};
  std::vector<std::uint32_t> met;
  std::mt19937 random(7);
  for (const std::vector<std::uint32_t>& of_matte : ids)
    for (std::uint64_t s = 0; s < kSamples; ++s)
      for (std::size_t i = 0; i < pixels.size(); ++i)
        met.push_back(s > 0 && random() % 4 != 0 ? met[met.size() - pixels.size()]
                                                 : std::uint32_t(random() % of_matte.size()));
  const test::UnitBuilder empty(layout, pixels, 8, 8 + kSamples);
  UnitSums unit = empty.sums();
  unit.matte_numbers = met;
  unit.matte_ids = ids;
  Film film(layout);
  film.add(unit);
  film.add(unit);
  for (std::size_t m = 0; m < ids.size(); ++m)
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      std::map<std::uint32_t, std::uint64_t> expected;
      for (std::uint64_t s = 0; s < kSamples; ++s) expected[ids[m][met[(m * kSamples + s) * pixels.size() + i]]] += 2;
      const std::vector<MatteCount> counts = film.matte(m, pixels[i] & 0xffffU, pixels[i] >> 16U);
      ASSERT_EQ(counts.size(), expected.size()) << m << ' ' << i;
      for (const MatteCount& count : counts) ASSERT_EQ(count.samples, expected[count.id]) << m << ' ' << i;
    }
  met[met.size() / 3] = 4;
  EXPECT_THROW(film.add(unit), InternalError);
}

TEST(Mattes, counts_come_back_from_a_file_and_add_up_in_any_order) {
  const TemporaryFolder folder;
  const FilmLayout layout = matte_layout();
  const ExrOptions options{.half = false, .layers = {}, .exact_sums = true};
  std::vector<Film> films;
  for (std::uint32_t i = 0; i < 3; ++i) {
    films.push_back(matte_film(layout, 11 * i));
    write_exr(folder / fmt::format("{}.exr", i), films.back(), {}, options);
    EXPECT_TRUE(same_mattes(read_film(folder / fmt::format("{}.exr", i)), films.back()));
  }
  Film sum(layout);
  for (const Film& film : films) sum.add(film);
  std::string bytes;
  std::vector<int> order = {0, 1, 2};
  do {
    Film read(layout);
    for (const int i : order) SumsReader(folder / fmt::format("{}.exr", i)).add_to(read);
    EXPECT_TRUE(same_mattes(read, sum));
    write_exr(folder / "sum.exr", read, {}, options);
    const std::string found = test::read_bytes(folder / "sum.exr");
    if (bytes.empty()) bytes = found;
    EXPECT_EQ(found, bytes);
  } while (std::ranges::next_permutation(order).found);
}

TEST(Mattes, no_changed_byte_gives_other_counts) {
  const TemporaryFolder folder;
  FilmLayout layout = matte_layout();
  layout.crop = {0, 0, 5, 4};
  const Film film = matte_film(layout, 3);
  write_exr(folder / "a.exr", film, {},
            {.half = false, .layers = {}, .exact_sums = true, .record = "this is what it is of\n"});
  const std::string whole = test::read_bytes(folder / "a.exr");
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); at += 7) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
    folder.write("b.exr", changed);
    try {
      SumsReader reader(folder / "b.exr");
      Film back(reader.layout());
      reader.add_to(back);
      ASSERT_TRUE(same_mattes(back, film)) << at;
    } catch (const InputError& error) {
      ++refused;
      EXPECT_FALSE(contains(error.what(), "\n"));
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(Mattes, the_picture_has_ranks_by_coverage_and_says_what_they_are) {
  const TemporaryFolder folder;
  const FilmLayout layout = matte_layout();
  const Film film = matte_film(layout, 7);
  ExrOptions options;
  options.half = true;  // which would make other ids of them
  options.layers = {"cryptomatte_material", "cryptomatte_object"};
  options.manifests = {{"cryptomatte_material", "{}"}, {"cryptomatte_object", "{\"x\":\"1\"}"}};
  write_exr(folder / "a.exr", film, {}, options);
  const Image image = read_exr(folder / "a.exr");
  EXPECT_EQ(image.channels.size(), 3U + 24U);
  for (std::size_t m = 0; m < 2; ++m)
    for (std::uint32_t y = layout.crop.y0; y < layout.crop.y1; ++y)
      for (std::uint32_t x = layout.crop.x0; x < layout.crop.x1; ++x) {
        const std::size_t at = (y - layout.crop.y0) * image.width + (x - layout.crop.x0);
        const std::vector<MatteCount> counts = film.matte(m, x, y);
        double all = 0;
        for (const MatteCount& count : counts) all += double(count.samples);
        std::size_t ids = 0;
        float before = 1;
        for (std::size_t rank = 0; rank < 6; ++rank) {
          const std::string name = fmt::format("{}{:02}.", layout.mattes[m], rank / 2);
          const float id = image.plane(name + "RB"[rank % 2])->at(at),
                      share = image.plane(name + "GA"[rank % 2])->at(at);
          EXPECT_LE(share, before);
          before = share;
          if (share == 0) {
            EXPECT_EQ(id, 0);
            continue;
          }
          ++ids;
          const auto found = std::ranges::find(counts, std::bit_cast<std::uint32_t>(id), &MatteCount::id);
          ASSERT_NE(found, counts.end());
          EXPECT_NE(found->id, 0U);
          EXPECT_EQ(share, float(double(found->samples) / all));
        }
        EXPECT_EQ(ids, std::min<std::size_t>(6, counts.size() - (counts.front().id == 0 ? 1 : 0)));
      }
  const Imf::MultiPartInputFile file((folder / "a.exr").c_str());
  const Imf::Header& header = file.header(0);
  EXPECT_EQ(header.channels().findChannel("cryptomatte_object02.A")->type, Imf::FLOAT);
  EXPECT_EQ(header.channels().findChannel("R")->type, Imf::HALF);
  for (const std::string& layer : layout.mattes) {
    const std::string key = "cryptomatte/" + matte_hex(matte_id(layer)).substr(0, 7) + "/";
    const auto text = [&](const char* name) { return header.typedAttribute<Imf::StringAttribute>(key + name).value(); };
    EXPECT_EQ(text("name"), layer);
    EXPECT_EQ(text("hash"), "MurmurHash3_32");
    EXPECT_EQ(text("conversion"), "uint32_to_float32");
    EXPECT_EQ(text("manifest"), options.manifests.at(layer));
  }
}

}  // namespace
}  // namespace eikon
