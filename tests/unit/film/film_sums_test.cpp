// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include "core/error.h"
#include "film/packed_sums.h"
#include "support/film_builder.h"
#include "instruments/analytic_scenes.h"
#include "support/fixed_point.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::message_of;
using test::random_film;
using test::small_layout;
using test::UnitBuilder;

constexpr int128 kOne = int128{1} << 64;

/// A pure function of its arguments, over 40 orders of magnitude and both signs.
float sample_value(std::uint32_t pixel, std::uint64_t sample, std::uint32_t channel) {
  std::mt19937 random(static_cast<unsigned>(pixel * 7919u + sample * 31u + channel));
  random.discard(2);
  const float magnitude = std::exp2(std::uniform_real_distribution<float>(-70, 37)(random));
  return random() % 4 == 0 ? -magnitude : magnitude;
}

UnitBuilder make_unit(const FilmLayout& layout, const std::vector<std::uint32_t>& pixels, std::uint64_t begin,
                      std::uint64_t end) {
  UnitBuilder unit(layout, pixels, begin, end);
  for (std::size_t p = 0; p < pixels.size(); ++p)
    for (std::uint64_t i = begin; i < end; ++i)
      for (std::uint32_t c = 0; c < 3; ++c) unit.add(p, i, c, to_fixed(sample_value(pixels[p], i, c)));
  return unit;
}

TEST(Film, fixed_point_is_the_floor_of_the_value_times_2_to_the_64) {
  EXPECT_TRUE(to_fixed(0.0f) == 0);
  EXPECT_TRUE(to_fixed(-0.0f) == 0);
  EXPECT_TRUE(to_fixed(1.0f) == kOne);
  EXPECT_TRUE(to_fixed(-1.5f) == -kOne - kOne / 2);
  EXPECT_TRUE(to_fixed(0x1p-64f) == 1);
  EXPECT_TRUE(to_fixed(0x1.fffffep-64f) == 1);
  EXPECT_TRUE(to_fixed(0x1p-65f) == 0);
  EXPECT_TRUE(to_fixed(-0x1p-65f) == -1);
  EXPECT_TRUE(to_fixed(std::numeric_limits<float>::denorm_min()) == 0);
  EXPECT_TRUE(to_fixed(-std::numeric_limits<float>::denorm_min()) == -1);
  EXPECT_TRUE(to_fixed(0x1.fffffep37f) == static_cast<int128>(0xffffff) << 78);
  std::mt19937 random(1);
  for (int i = 0; i < 100'000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!fits_film(value)) continue;
    // x87 long double has 64 bits of mantissa: the product and its floor are exact.
    const long double scaled = std::floor(std::ldexp(static_cast<long double>(value), 64));
    ASSERT_TRUE(to_fixed(value) == static_cast<int128>(scaled)) << value;
  }
}

TEST(Film, what_is_not_finite_or_reaches_2_to_the_38_does_not_fit) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const float value : {inf, -inf, nan, 0x1p38f, -0x1p38f, 0x1p127f}) {
    EXPECT_FALSE(fits_film(value)) << value;
    EXPECT_THROW(static_cast<void>(to_fixed(value)), InternalError) << value;
  }
  EXPECT_TRUE(fits_film(-0x1.fffffep37f));
}

TEST(Film, every_number_is_rounded_as_the_compiler_rounds_it) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 300'000; ++i) {
    int128 number = (static_cast<int128>(static_cast<std::int64_t>(random())) << 64 | random()) >> (random() % 127);
    if (i % 3 == 0) number = (number >> 20) << 20;                                   // ends in zeros: ties
    if (i % 3 == 1) number = (number >> 12 << 12) + static_cast<int>(random() % 3) - 1;  // beside them
    ASSERT_EQ(to_double(number), std::ldexp(static_cast<double>(number), -64));
    ASSERT_EQ(to_mean(number, 8), std::ldexp(static_cast<double>(number), -67));
  }
}

TEST(Film, rows_have_the_bits_of_their_pixels) {
  // Samples of each replicate: the same power of two, the same odd number, none, and different
  // ones.
  for (const int kind : {0, 1, 2, 3})
    for (const std::uint32_t replicates : {1U, 2U, 4U}) {
      const FilmLayout layout = small_layout(19, 3, replicates);
      Film film = random_film(layout, 8);
      std::mt19937 random(9);
      for (std::uint32_t y = 0; y < 3; ++y)
        for (std::uint32_t x = 0; x < 19; ++x)
          for (std::uint32_t r = 0; r < replicates; ++r) {
            film.set_count(x, y, r, kind == 0 ? 4 : kind == 1 ? 7 : kind == 2 ? 0 : 1 + random() % 9);
            for (std::uint32_t c = 0; c < 3; ++c)
              film.set(x, y, r, c, film.sum(x, y, r, c) >> (random() % 100));
          }
      for (std::uint32_t y = 0; y < 3; ++y)
        for (std::uint32_t c = 0; c < 3; ++c) {
          std::vector<double> means(19), variances(19);
          std::vector<float> floats(19);
          film.row_means_and_variances(y, c, means.data(), variances.data());
          film.row_means(y, c, floats.data());
          for (std::uint32_t x = 0; x < 19; ++x) {
            ASSERT_EQ(means[x], film.mean(x, y, c));
            ASSERT_EQ(floats[x], static_cast<float>(film.mean(x, y, c)));
            ASSERT_EQ(std::bit_cast<std::uint64_t>(variances[x]), std::bit_cast<std::uint64_t>(film.variance_of_mean(x, y, c)))
                << kind << " " << replicates;
          }
        }
    }
}

TEST(Film, fixed_point_to_double_is_rounded_to_nearest_even) {
  EXPECT_EQ(to_double(0), 0.0);
  EXPECT_EQ(to_double(kOne), 1.0);
  EXPECT_EQ(to_double(-kOne / 4), -0.25);
  EXPECT_EQ(to_double(1), 0x1p-64);
  const int128 odd = (int128{1} << 53) + 1;  // a tie: to even, down; then up
  EXPECT_EQ(to_double(odd), 0x1p-11);
  EXPECT_EQ(to_double((int128{1} << 53) + 3), 0x1.0000000000002p-11);
  EXPECT_EQ(to_double((int128{1} << 53 << 40) + (int128{1} << 40) + 1), 0x1.0000000000001p29);  // just above a tie
  const int128 largest = ((int128{1} << 126) - 1) * 2 + 1;
  EXPECT_EQ(to_double(largest), 0x1p63);
  EXPECT_EQ(to_double(-largest - 1), -0x1p63);
}

TEST(Film, means_are_correctly_rounded_quotients_of_integers) {
  EXPECT_EQ(to_mean(kOne, 3), 1.0 / 3.0);
  EXPECT_EQ(to_mean(-kOne * 2, 3), -2.0 / 3.0);
  EXPECT_EQ(to_mean(kOne, 0), 0.0);
  EXPECT_EQ(to_mean(1, std::numeric_limits<std::uint64_t>::max()), 0x1p-128);
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    // Integers of at most 53 bits are exact doubles, whose IEEE quotient is correctly rounded.
    const std::int64_t numerator = static_cast<std::int64_t>(random()) >> (11 + random() % 50);
    const std::uint64_t count = (random() >> (11 + random() % 50)) + 1;
    const int shift = static_cast<int>(random() % 70);
    ASSERT_EQ(to_mean(static_cast<int128>(numerator) << shift, count),
              std::ldexp(static_cast<double>(numerator) / static_cast<double>(count), shift - 64))
        << numerator << " << " << shift << " / " << count;
  }
  // The tie 2^53 + 1 goes to the even side, its neighbours to theirs, for a divisor that is no
  // power of two.
  const int128 tie = ((int128{1} << 53) + 1) * 48;
  EXPECT_EQ(to_mean(tie - 1, 48), std::ldexp(0x1p53, -64));
  EXPECT_EQ(to_mean(tie, 48), std::ldexp(0x1p53, -64));
  EXPECT_EQ(to_mean(tie + 1, 48), std::ldexp(0x1p53 + 2, -64));
}

TEST(Film, N1_means_of_a_million_tenths_and_of_2_to_the_24_plus_one_ones_are_exact) {
  const FilmLayout layout = small_layout(1, 1);
  Film tenth(layout), one(layout);
  UnitBuilder tenths(layout, {0}, 0, 1'000'000);
  for (std::uint64_t i = 0; i < 1'000'000; ++i) tenths.add(0, i, 0, to_fixed(0.1f));
  tenth.add(tenths.sums());
  EXPECT_EQ(tenth.samples(0, 0), 1'000'000u);
  EXPECT_EQ(tenth.mean(0, 0, 0), static_cast<double>(0.1f));

  const std::uint64_t many = (1u << 24) + 1;
  UnitBuilder ones(layout, {0}, 0, many);
  for (std::uint64_t i = 0; i < many; ++i) ones.add(0, i, 0, kOne);
  one.add(ones.sums());
  EXPECT_EQ(one.count(0, 0, 0), (1u << 23) + 1);
  EXPECT_EQ(one.count(0, 0, 1), 1u << 23);
  EXPECT_EQ(one.mean(0, 0, 0), 1.0);
}

TEST(Film, N4_any_split_in_any_order_gives_the_same_bits) {
  const FilmLayout layout = small_layout(5, 4, 4);
  std::vector<std::uint32_t> all;
  for (std::uint32_t y = 0; y < 4; ++y)
    for (std::uint32_t x = 0; x < 5; ++x) all.push_back(x | y << 16);
  Film whole(layout);
  whole.add(make_unit(layout, all, 0, 37).sums());

  std::mt19937 random(3);
  for (int run = 0; run < 20; ++run) {
    std::vector<UnitBuilder> units;
    std::vector<std::uint32_t> pixels = all;
    std::shuffle(pixels.begin(), pixels.end(), random);
    const std::size_t cut = 1 + random() % (pixels.size() - 1);
    for (const auto& part : {std::vector(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(cut)),
                             std::vector(pixels.begin() + static_cast<std::ptrdiff_t>(cut), pixels.end())})
      for (std::uint64_t begin = 0; begin < 37;) {
        const std::uint64_t end = std::min<std::uint64_t>(37, begin + 1 + random() % 17);
        units.push_back(make_unit(layout, part, begin, end));
        begin = end;
      }
    std::shuffle(units.begin(), units.end(), random);
    Film first(layout), second(layout);
    for (std::size_t i = 0; i < units.size(); ++i) (i % 3 == 0 ? first : second).add(units[i].sums());
    first.add(second);
    ASSERT_TRUE(same_bits(first, whole)) << "run " << run;
  }
}

TEST(Film, a_unit_that_several_threads_add_has_the_bits_of_its_rows) {
  const std::uint32_t width = 300, height = 250;  // four parts of 2^14 pixels, and a rest
  const FilmLayout layout = small_layout(width, height);
  std::vector<std::uint32_t> all;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) all.push_back(x | y << 16);
  Film whole(layout), rows(layout);
  whole.add(make_unit(layout, all, 3, 5).sums());
  for (std::uint32_t y = 0; y < height; ++y) {
    const auto row = all.begin() + std::ptrdiff_t{y} * width;
    rows.add(make_unit(layout, std::vector(row, row + width), 3, 5).sums());
  }
  EXPECT_TRUE(same_bits(whole, rows));
}

TEST(Film, a_film_of_a_part_adds_into_the_whole) {
  FilmLayout part_layout = small_layout(8, 6);
  part_layout.crop = {2, 1, 5, 6};
  const Film part = random_film(part_layout, 4);
  Film whole(small_layout(8, 6));
  whole.add(part);
  EXPECT_TRUE(whole.sum(4, 5, 1, 2) == part.sum(4, 5, 1, 2));
  EXPECT_EQ(whole.count(2, 1, 0), part.count(2, 1, 0));
  EXPECT_EQ(whole.samples(1, 1), 0u);
  Film other(part_layout);
  EXPECT_THROW(other.add(whole), InternalError);
}

TEST(Film, negative_samples_count) {
  const FilmLayout layout = small_layout(1, 1, 1);
  Film film(layout);
  UnitBuilder unit(layout, {0}, 0, 4);
  for (const auto& [i, value] : {std::pair{0, 1.0f}, {1, -3.0f}, {2, 0.5f}, {3, -0.5f}})
    unit.add(0, static_cast<std::uint64_t>(i), 1, to_fixed(value));
  film.add(unit.sums());
  EXPECT_EQ(film.mean(0, 0, 1), -0.5);
}

TEST(Film, N12_rejected_samples_are_not_counted) {
  const FilmLayout layout = small_layout(2, 1);
  Film film(layout);
  UnitBuilder unit(layout, {1}, 3, 10);  // replicate 0: 4 6 8, replicate 1: 3 5 7 9
  unit.reject(0, 5);
  unit.add(0, 3, 0, kOne * 6);
  film.add(unit.sums());
  EXPECT_EQ(film.count(1, 0, 0), 3u);
  EXPECT_EQ(film.count(1, 0, 1), 3u);
  EXPECT_EQ(film.mean(1, 0, 0), 1.0);
  EXPECT_EQ(film.samples(0, 0), 0u);
}

TEST(Film, N3_sample_indices_up_to_2_to_the_64_are_counted_without_overflow) {
  const FilmLayout layout = small_layout(1, 1, 4);
  Film film(layout);
  const std::uint64_t end = std::numeric_limits<std::uint64_t>::max();  // not reached: the last index is 2^64 - 2
  film.add(UnitBuilder(layout, {0}, end - 5, end).sums());
  EXPECT_EQ(film.samples(0, 0), 5u);
  EXPECT_EQ(film.count(0, 0, (end - 1) % 4), 2u);
}

TEST(Film, a_sum_beyond_the_range_is_an_error_that_names_the_pixel) {
  const FilmLayout layout = small_layout(3, 2);
  Film film(layout);
  UnitBuilder unit(layout, {2u | 1u << 16}, 0, 2);
  unit.add(0, 0, 0, to_fixed(0x1.fffffep37f) * (int128{1} << 24));  // nearly all that a sum can hold
  film.add(unit.sums());
  EXPECT_TRUE(contains(message_of([&] { film.add(unit.sums()); }), "pixel 2,1"));
}

/// Packs the sums of a unit; nothing if some do not fit.
std::optional<std::vector<std::uint32_t>> packed(const UnitSums& unit, const FilmLayout& layout) {
  const std::size_t sums = layout.replicates * layout.channels.size(), stride = unit.pixel_stride;
  std::vector<std::uint32_t> words(packed_words(sums, stride));
  for (std::size_t k = 0; k < sums; ++k)
    for (std::size_t i = 0; i < unit.pixels.size(); ++i) {
      unsigned __int128 value = 0;
      for (std::size_t limb = EK_FILM_LIMBS; limb-- > 0;)
        value = value << 32 | unit.limbs[(k * EK_FILM_LIMBS + limb) * stride + i];
      const std::optional<PackedSum> sum = packed_sum(static_cast<int128>(value));
      if (!sum) return std::nullopt;
      std::uint32_t* const at = &words[EK_PACKED_HEAD + i];
      at[2 * k * stride] = std::uint32_t(std::uint64_t(sum->number));
      at[(2 * k + 1) * stride] = std::uint32_t(std::uint64_t(sum->number) >> 32);
      at[(2 * sums + k / 4) * stride] |= sum->shift << 8 * (k % 4);
    }
  return words;
}

TEST(Film, packed_sums_are_added_as_the_others_are) {
  for (const std::uint32_t replicates : {1U, 2U, 8U}) {
    FilmLayout layout = small_layout(20, 15, replicates);
    layout.channels.push_back("depth");
    std::vector<std::uint32_t> pixels;
    for (std::uint32_t y = 1; y < 14; ++y)
      for (std::uint32_t x = 2; x < 19; ++x) pixels.push_back(x | y << 16);
    UnitBuilder unit(layout, pixels, 3, 40);
    std::mt19937 random(replicates);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      for (std::uint64_t sample = 3; sample < 40; ++sample)
        for (std::size_t c = 0; c < 4; ++c)
          unit.add(i, sample, c, to_fixed(std::ldexp(float(random() % 2000) - 1000, int(i % 60) - 50)));
    unit.reject(7, 5);
    const UnitSums sums = unit.sums();
    const auto words = packed(sums, layout);
    ASSERT_TRUE(words);
    UnitSums of_words = sums;
    of_words.limbs = {};
    of_words.packed = *words;
    Film one(layout), other(layout);
    one.add(sums);
    other.add(of_words);
    for (std::uint32_t y = 0; y < 15; ++y) {
      EXPECT_TRUE(std::ranges::equal(one.row_sums(y), other.row_sums(y))) << y;
      EXPECT_TRUE(std::ranges::equal(one.row_counts(y), other.row_counts(y))) << y;
    }
    EXPECT_NE(one.sum(4, 5, 0, 3), 0);
    std::vector<std::uint32_t> wide = *words;
    wide[0] = 1;  // the device says that a sum does not fit
    of_words.packed = wide;
    EXPECT_THROW(other.add(of_words), InternalError);
    of_words.packed = std::span(*words).first(words->size() - 1);
    EXPECT_THROW(other.add(of_words), InternalError);
  }
}

TEST(Film, units_that_do_not_fit_are_refused) {
  const FilmLayout layout = small_layout(3, 2);
  Film film(layout);
  EXPECT_THROW(film.add(UnitBuilder(layout, {3}, 0, 1).sums()), InternalError);
  UnitSums short_unit = UnitBuilder(layout, {0}, 0, 1).sums();
  short_unit.limbs = short_unit.limbs.first(7);
  EXPECT_THROW(film.add(short_unit), InternalError);
  UnitBuilder rejecting(layout, {0}, 0, 1);
  rejecting.reject(0, 1);
  EXPECT_THROW(film.add(rejecting.sums()), InternalError);
}

TEST(Film, layouts_that_make_no_sense_are_refused) {
  FilmLayout outside = small_layout(4, 4), empty = outside, three = outside, grey = outside;
  outside.crop.x1 = 5;
  empty.crop.y1 = 0;
  three.replicates = 3;
  grey.channels = {"Y"};
  for (const FilmLayout& layout : {outside, empty, three, grey}) EXPECT_THROW(Film{layout}, InternalError);
}

}  // namespace
}  // namespace eikon
