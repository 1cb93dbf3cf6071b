// SPDX-License-Identifier: Apache-2.0
// How a light is chosen: the table's shares are those of its words, the kernels choose what it
// says, and what is left of the random words is as good as new.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "kernels/lights/alias_table.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

/// How many words choose each light, found by bisection: within a bucket the choice changes once.
std::vector<std::uint64_t> count_words(const LightTable& table) {
  const std::uint64_t lights = table.buckets.size();
  const auto first_word = [&](auto&& beyond, std::uint64_t lo, std::uint64_t hi) {
    while (lo < hi) {
      const std::uint64_t middle = (lo + hi) / 2;
      if (beyond(middle))
        hi = middle;
      else
        lo = middle + 1;
    }
    return lo;
  };
  std::vector<std::uint64_t> words(lights, 0);
  std::uint64_t begin = 0;
  for (std::uint64_t bucket = 0; bucket < lights; ++bucket) {
    const std::uint64_t end =
        first_word([&](std::uint64_t a) { return (a * lights) >> 32 > bucket; }, begin, std::uint64_t{1} << 32);
    const std::uint64_t turn = first_word(
        [&](std::uint64_t a) { return std::uint32_t(a * lights) >= table.buckets[bucket].threshold; }, begin, end);
    words[bucket] += turn - begin;
    words[table.buckets[bucket].alias] += end - turn;
    begin = end;
  }
  return words;
}

std::vector<std::vector<double>> power_lists() {
  std::mt19937 random(1);
  std::vector<std::vector<double>> lists{{1},           {0, 0, 3},     {1, 1, 1, 1},   {1, 2, 3, 4, 5},
                                         {1e30, 1e-10}, {0, 1e-10, 0}, {5e-324, 1e300}};
  lists.emplace_back();
  for (int i = 0; i < 1000; ++i) lists.back().push_back(std::pow(10.0, 4.0 * double(random()) / 4294967296.0));
  lists.emplace_back();  // L16
  for (int i = 0; i < 100000; ++i)
    lists.back().push_back(i % 10 == 3 ? 0.0 : std::pow(10.0, 20.0 * double(random()) / 4294967296.0 - 10.0));
  lists.back()[54321] = 1e30;
  return lists;
}

TEST(LightTable, L16_probabilities_are_those_of_the_words_and_vanish_for_powerless_lights_only) {
  for (const auto& powers : power_lists()) {
    const LightTable table = build_light_table(powers);
    const auto words = count_words(table);
    double sum = 0;
    for (std::size_t i = 0; i < powers.size(); ++i) {
      ASSERT_EQ(table.probability[i], double(words[i]) * 0x1p-32) << "light " << i << " of " << powers.size();
      ASSERT_EQ(table.probability[i] > 0, powers[i] > 0) << "light " << i << " of " << powers.size();
      sum += table.probability[i];
    }
    EXPECT_EQ(sum, 1.0) << powers.size() << " lights";
  }
}

TEST(LightTable, strong_lights_get_their_share_of_the_power_and_weak_ones_the_stated_minimum) {
  for (const auto& powers : power_lists()) {
    const LightTable table = build_light_table(powers);
    double largest = 0, total = 0;
    for (const double p : powers) largest = std::max(largest, p);
    for (const double p : powers) total += p / largest;
    const double least = 0x1p-8 / double(powers.size());
    for (std::size_t i = 0; i < powers.size(); ++i) {
      if (powers[i] == 0) continue;
      const double wanted = std::max(powers[i] / largest / total, least);
      ASSERT_NEAR(table.probability[i], wanted, wanted * 0x1p-7 + 0x1p-30) << "light " << i << " of " << powers.size();
    }
  }
}

TEST(LightTable, nothing_to_choose_from_gives_no_buckets_and_nonsense_is_refused) {
  EXPECT_TRUE(build_light_table(std::vector<double>{}).buckets.empty());
  EXPECT_TRUE(build_light_table(std::vector<double>{0, 0}).buckets.empty());
  EXPECT_THROW(build_light_table(std::vector<double>{1, -1}), std::runtime_error);
  EXPECT_THROW(build_light_table(std::vector<double>{1, std::nan("")}), std::runtime_error);
  EXPECT_THROW(build_light_table(std::vector<double>{INFINITY}), std::runtime_error);
}

struct TableChoices {
  Words light;
  std::vector<float> u, v;
};

TableChoices choose_on_devices(const LightTable& table, const Words& a, const Words& b) {
  const auto out = Probe("light")
                       .buffer("light_alias_table", table.buckets)
                       .value("light_count", std::uint32_t(table.buckets.size()))
                       .run("probe_alias_table", {a, b}, 3);
  TableChoices c{.light = out[0], .u = {}, .v = {}};
  for (std::size_t i = 0; i < a.size(); ++i) {
    c.u.push_back(as_float(out[1][i]));
    c.v.push_back(as_float(out[2][i]));
  }
  return c;
}

TEST(Light, kernels_choose_what_the_table_says) {
  std::mt19937 random(2);
  for (const auto& powers : power_lists()) {
    const LightTable table = build_light_table(powers);
    Words a = random_words(random, 1 << 16);
    a[0] = 0;
    a[1] = 0xffffffffU;
    const TableChoices c = choose_on_devices(table, a, random_words(random, a.size()));
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(c.light[i], choose(table, a[i])) << a[i];
      ASSERT_GT(powers[c.light[i]], 0) << "a light without power was chosen";
      ASSERT_TRUE(c.u[i] >= 0 && c.u[i] < 1 && c.v[i] >= 0 && c.v[i] < 1) << c.u[i] << ", " << c.v[i];
    }
  }
}

TEST(Light, what_is_left_of_the_sample_is_uniform_and_independent_within_each_light) {
  std::mt19937 random(3);
  constexpr unsigned kCells = 16;
  const std::vector<double> powers{1, 2, 3, 4, 5, 0.01, 0, 30};
  const LightTable table = build_light_table(powers);
  const Words a = random_words(random, 1 << 20);
  const TableChoices c = choose_on_devices(table, a, random_words(random, a.size()));
  std::vector<double> chosen(powers.size(), 0);
  std::vector<std::vector<double>> cells(powers.size(), std::vector<double>(kCells * kCells, 0));
  for (std::size_t i = 0; i < a.size(); ++i) {
    ++chosen[c.light[i]];
    ++cells[c.light[i]][unsigned(c.u[i] * kCells) * kCells + unsigned(c.v[i] * kCells)];
  }
  std::vector<double> expected;
  for (const double p : table.probability) expected.push_back(p * double(a.size()));
  const double alpha = sidak(powers.size() + 1);
  EXPECT_GT(chi_square(chosen, expected).p_value, alpha);
  for (std::size_t light = 0; light < powers.size(); ++light) {
    if (powers[light] == 0) continue;
    const std::vector<double> even(kCells * kCells, chosen[light] / (kCells * kCells));
    EXPECT_GT(chi_square(cells[light], even).p_value, alpha) << "light " << light;
  }
}

TEST(Light, strata_of_the_sample_stay_strata_of_the_light) {
  const LightTable table = build_light_table(std::vector<double>{1, 1, 1, 1});
  std::mt19937 random(4);
  Words a;
  for (std::uint32_t k = 0; k < 64; ++k) a.push_back((k << 26) | (std::uint32_t(random()) >> 6));
  const TableChoices c = choose_on_devices(table, a, random_words(random, 64));
  std::set<std::pair<std::uint32_t, unsigned>> strata;
  for (std::size_t i = 0; i < 64; ++i) strata.emplace(c.light[i], unsigned(c.u[i] * 16));
  EXPECT_EQ(strata.size(), 64U) << "one sample in each sixteenth of each of four lights";
}

TEST(Light, an_unlikely_light_is_still_sampled_all_over) {
  std::vector<double> powers(30000, 1.0);
  powers[12345] = 1e-20;  // least probability: 2^-8 / 30000, or some 500 words
  const LightTable mixed = build_light_table(powers);
  ASSERT_LT(mixed.probability[12345] * 0x1p32, 1000);
  Words choosing;
  const std::uint64_t first = (std::uint64_t{12345} << 32) / powers.size();
  for (std::uint64_t word = first; word < first + 2000; ++word)
    if (choose(mixed, std::uint32_t(word)) == 12345) choosing.push_back(std::uint32_t(word));
  ASSERT_EQ(double(choosing.size()), mixed.probability[12345] * 0x1p32);
  std::mt19937 random(5);
  Words a;
  for (int i = 0; i < 1000000; ++i) a.push_back(choosing[random() % choosing.size()]);
  const TableChoices c = choose_on_devices(mixed, a, random_words(random, a.size()));
  constexpr unsigned kCells = 64;  // of 8.7 words each: without the bits of b, some would have 8 and others 9
  std::vector<double> observed(kCells, 0);
  for (const float u : c.u) ++observed[unsigned(u * kCells)];
  const ChiSquare test = chi_square(observed, std::vector<double>(kCells, double(a.size()) / kCells));
  EXPECT_GT(test.p_value, kSignificance) << test.table;
}

}  // namespace
}  // namespace eikon::test
