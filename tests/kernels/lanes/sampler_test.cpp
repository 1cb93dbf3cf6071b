// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "kernels/probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

struct Setting {
  std::uint32_t seed = 0, index_high = 0, dimension = 0;
};

/// Places of samples: pixel, replicate, index.
struct Places {
  Words x, y, replicate, index;
  void add(std::uint32_t px, std::uint32_t py, std::uint32_t r, std::uint32_t i) {
    x.push_back(px);
    y.push_back(py);
    replicate.push_back(r);
    index.push_back(i);
  }
};

/// Outputs of probe_samples: words a, b; floats x, y; key.
std::vector<Words> samples(const Places& at, Setting s) {
  return Probe("sampler")
      .value("seed", s.seed)
      .value("index_high", s.index_high)
      .value("dimension", s.dimension)
      .run("probe_samples", {at.x, at.y, at.replicate, at.index}, 5);
}

Places sequence(std::uint32_t count, std::uint32_t x = 7, std::uint32_t y = 11, std::uint32_t replicate = 0,
                std::uint32_t first = 0) {
  Places at;
  for (std::uint32_t i = 0; i < count; ++i) at.add(x, y, replicate, first + i);
  return at;
}

TEST(Sampler, second_sobol_dimension_has_the_published_points_and_the_recurrence_of_its_direction_numbers) {
  Words index, nothing;
  for (std::uint32_t i = 0; i < 1U << 16; ++i) index.push_back(i);
  std::mt19937 random(1);
  for (int i = 0; i < 1 << 16; ++i) index.push_back(std::uint32_t(random()));
  nothing.resize(index.size());
  const Words y = Probe("sampler").run("probe_words", {index, nothing}, 5)[3];
  const double published[] = {0, .5, .75, .25, .625, .125, .375, .875};  // [Joe and Kuo 2008], index order
  for (std::size_t i = 0; i < std::size(published); ++i) EXPECT_EQ(y[i] * 0x1p-32, published[i]) << i;
  for (std::size_t i = 0; i < index.size(); ++i) {
    std::uint32_t sum = 0, direction = 0x80000000U;  // v_k = v_{k-1} ^ (v_{k-1} >> 1): primitive polynomial x + 1
    for (std::uint32_t rest = index[i]; rest != 0; rest >>= 1) {
      if ((rest & 1U) != 0) sum ^= direction;
      direction ^= direction >> 1;
    }
    ASSERT_EQ(y[i], sum) << index[i];
  }
}

TEST(Sampler, bits_are_reversed_and_hashed_one_to_one) {
  std::mt19937 random(2);
  Words words, nothing;
  for (int i = 0; i < 1 << 16; ++i) words.push_back(std::uint32_t(random()));
  nothing.resize(words.size());
  const auto out = Probe("sampler").run("probe_words", {words, nothing}, 5);
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::uint32_t reversed = 0;
    for (unsigned b = 0; b < 32; ++b) reversed |= ((words[i] >> b) & 1U) << (31 - b);
    ASSERT_EQ(out[1][i], reversed);
  }
  const std::set<std::uint32_t> before(words.begin(), words.end()), after(out[0].begin(), out[0].end());
  EXPECT_EQ(before.size(), after.size());
}

// An Owen scramble may change a bit only by looking at higher ones; on reversed words, at lower
// ones.
TEST(Sampler, scramble_looks_at_lower_bits_only_and_flips_each_with_probability_one_half) {
  std::mt19937 random(3);
  constexpr std::size_t kSeeds = 4096;
  for (unsigned bit = 0; bit < 32; bit += 3) {
    Words x, seed;
    const std::uint32_t base = std::uint32_t(random());
    for (std::size_t i = 0; i < kSeeds; ++i) {
      const auto s = std::uint32_t(random());
      for (const std::uint32_t word : {base, base ^ (1U << bit)}) {
        x.push_back(word);
        seed.push_back(s);
      }
    }
    const Words out = Probe("sampler").run("probe_words", {x, seed}, 5)[2];
    std::vector<double> flips(32, 0);
    for (std::size_t i = 0; i < kSeeds; ++i) {
      const std::uint32_t change = out[2 * i] ^ out[2 * i + 1];
      ASSERT_EQ(change & ((1U << bit) - 1U), 0U) << "bit " << bit << " changed a lower one";
      ASSERT_NE(change & (1U << bit), 0U) << "bit " << bit << " was lost";
      for (unsigned b = bit + 1; b < 32; ++b) flips[b] += double((change >> b) & 1U);
    }
    // A good hash is within 4 sigma of one half nearly everywhere; Vegdahl's is within 0.05 for the
    // bits next above.
    for (unsigned b = bit + 1; b < 32; ++b)
      EXPECT_NEAR(flips[b] / kSeeds, 0.5, 0.12) << "bit " << bit << " to bit " << b;
  }
}

// Every elementary interval of area 2^-m holds exactly one of 2^m points.
void expect_net(const Words& a, const Words& b, std::size_t first, unsigned m) {
  for (unsigned j = 0; j <= m; ++j) {
    std::vector<int> cells(std::size_t{1} << m, 0);
    for (std::size_t i = first; i < first + cells.size(); ++i) {
      const std::uint64_t column = std::uint64_t{a[i]} >> (32 - j), row = std::uint64_t{b[i]} >> (32 - (m - j));
      ++cells[(column << (m - j)) | row];
    }
    ASSERT_EQ(std::count(cells.begin(), cells.end(), 1), std::ptrdiff_t(cells.size())) << "m " << m << ", j " << j;
  }
}

TEST(Sampler, every_aligned_block_of_two_to_the_m_samples_is_a_net_after_shuffling_and_scrambling) {
  for (const std::uint32_t dimension : {0U, 1U, 5U, 400U})
    for (const std::uint32_t pixel : {0U, 1U, 65535U}) {
      const auto out = samples(sequence(4096, pixel, 65535 - pixel, pixel & 1U), {.dimension = dimension});
      for (unsigned m = 0; m <= 12; ++m)
        for (std::size_t first = 0; first < 4096; first += std::size_t{1} << m) expect_net(out[0], out[1], first, m);
    }
}

TEST(Sampler, N3_nets_hold_at_the_end_of_the_index_range) {
  const auto out =
      samples(sequence(1024, 65535, 65535, 1, 0xffffffffU - 1023U), {.seed = 0xffffffffU, .index_high = 9});
  expect_net(out[0], out[1], 0, 10);
}

TEST(Sampler, dimensions_pixels_replicates_seeds_and_high_indices_are_independent) {
  constexpr std::uint32_t kPixels = 1U << 18;
  constexpr unsigned kCells = 8;
  struct Case {
    std::string what;
    Setting other;
    std::uint32_t dx = 0, dy = 0, dr = 0;
  };
  std::vector<Case> cases{{.what = "next dimension", .other = {.dimension = 1}},
                          {.what = "dimension of the next bounce", .other = {.dimension = 4}},
                          {.what = "far dimension", .other = {.dimension = 0x80000000U}},
                          {.what = "next pixel in x", .other = {}, .dx = 1},
                          {.what = "next pixel in y", .other = {}, .dy = 1},
                          {.what = "pixel 512 to the right", .other = {}, .dx = 512},
                          {.what = "other replicate", .other = {}, .dr = 1},
                          {.what = "next seed", .other = {.seed = 1}},
                          {.what = "last seed", .other = {.seed = 0xffffffffU}},
                          {.what = "2^32 samples later", .other = {.index_high = 1}}};
  // For each case: x with x, y with y, x with y, y with x of the two samples, and within a sample x
  // with y.
  const double alpha = sidak(cases.size() * 4 + 1);
  const auto joint = [&](const Words& p, const Words& q, const std::string& what) {
    std::vector<double> observed(kCells * kCells, 0), expected(kCells * kCells, double(kPixels) / (kCells * kCells));
    for (std::size_t i = 0; i < p.size(); ++i) ++observed[(p[i] >> 29) * kCells + (q[i] >> 29)];
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, alpha) << what << '\n' << test.table;
  };
  const auto pixels = [&](const Case& c) {
    Places at;
    for (std::uint32_t i = 0; i < kPixels; ++i) at.add((i & 511U) + c.dx, (i >> 9) + c.dy, c.dr, 0);
    return at;
  };
  const auto base = samples(pixels({}), {});
  joint(base[0], base[1], "x and y of one sample");
  for (const Case& c : cases) {
    const auto other = samples(pixels(c), c.other);
    joint(base[0], other[0], c.what + ", x and x");
    joint(base[1], other[1], c.what + ", y and y");
    joint(base[0], other[1], c.what + ", x and y");
    joint(base[1], other[0], c.what + ", y and x");
  }
}

// What differs between two orders of the same net's points must not repeat between dimensions: else
// padding shows.
TEST(Sampler, padded_pairs_fill_four_dimensions_evenly) {
  constexpr std::uint32_t kCount = 1U << 16;
  const auto first = samples(sequence(kCount), {.dimension = 4}), second = samples(sequence(kCount), {.dimension = 5});
  std::vector<double> observed(4096, 0), expected(4096, double(kCount) / 4096);
  for (std::size_t i = 0; i < kCount; ++i)
    ++observed[((first[0][i] >> 29) << 9) | ((first[1][i] >> 29) << 6) | ((second[0][i] >> 29) << 3) |
               (second[1][i] >> 29)];
  EXPECT_GT(chi_square(observed, expected).p_value, kSignificance);
}

TEST(Sampler, scrambled_nets_integrate_a_smooth_function_thirty_times_better_than_independent_samples) {
  constexpr std::uint32_t kCount = 1024, kRuns = 256;
  Places at;
  for (std::uint32_t run = 0; run < kRuns; ++run)
    for (std::uint32_t i = 0; i < kCount; ++i) at.add(run, 3, 1, i);
  const auto out = samples(at, {.dimension = 9});
  const double exact = (std::exp(1.0) - 1) * (std::exp(1.0) - 1);
  double squares = 0, bias = 0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    double sum = 0;
    for (std::uint32_t i = 0; i < kCount; ++i)
      sum +=
          std::exp(double(as_float(out[2][run * kCount + i]))) * std::exp(double(as_float(out[3][run * kCount + i])));
    const double error = sum / kCount - exact;
    squares += error * error;
    bias += error;
  }
  const double rms = std::sqrt(squares / kRuns);
  const double half = (std::exp(2.0) - 1) / 2;
  const double independent = std::sqrt((half * half - exact * exact) / kCount);
  EXPECT_LT(rms, independent / 30);
  EXPECT_LT(std::abs(bias / kRuns), 4 * rms / std::sqrt(double(kRuns)));
}

TEST(Sampler, N2_the_largest_word_becomes_less_than_one) {
  const auto out =
      Probe("sampler").run("probe_words", {{0xffffffffU, 0xffffff00U, 0, 255, 256}, {0, 0, 0, 0, 0}}, 5)[4];
  EXPECT_EQ(out, as_words({1 - 0x1p-24F, 1 - 0x1p-24F, 0, 0, 0x1p-24F}));
}

TEST(Sampler, N3_no_two_pixels_of_a_replicate_share_a_key_even_at_the_corners_of_the_largest_image) {
  Places at;
  for (std::uint32_t i = 0; i < 1U << 20; ++i) at.add(i & 1023U, i >> 10, 0, 0);
  for (std::uint32_t i = 0; i < 1U << 18; ++i) at.add(65535 - (i & 511U), 65535 - (i >> 9), 0, 0);  // index above 2^31
  for (const std::uint32_t seed : {0U, 0xffffffffU}) {
    Words keys = samples(at, {.seed = seed})[4];
    std::sort(keys.begin(), keys.end());
    EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end()) << seed;
  }
}

// Of the first pixel above all, whose number is 0: light paths have its keys, too.
TEST(Sampler, keys_differ_by_seed_replicate_and_high_index_at_every_pixel) {
  Places at;
  for (std::uint32_t i = 0; i < 16; ++i) at.add(i & 1U, i >> 1 & 1U, i >> 2, 0);
  std::set<std::uint32_t> seen;
  std::size_t drawn = 0;
  for (const std::uint32_t seed : {0U, 1U, 2U, 0x6c70a7b5U, 0xffffffffU})
    for (const std::uint32_t high : {0U, 1U, 0xffffffffU}) {
      const Words keys = samples(at, {.seed = seed, .index_high = high})[4];
      seen.insert(keys.begin(), keys.end());
      drawn += keys.size();
    }
  EXPECT_EQ(seen.size(), drawn);
}

TEST(Sampler, N3_samples_do_not_repeat_past_two_to_the_32_or_in_far_dimensions) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  std::size_t drawn = 0;
  for (const std::uint32_t high : {0U, 1U, 2U, 0xffffffffU})
    for (const std::uint32_t dimension : {0U, 3U, 4U, 1000003U, 0xffffffffU}) {
      const auto out = samples(sequence(4096), {.index_high = high, .dimension = dimension});
      for (std::size_t i = 0; i < 4096; ++i) seen.emplace(out[0][i], out[1][i]);
      drawn += 4096;
    }
  EXPECT_EQ(seen.size(), drawn);
}

TEST(Sampler, every_decision_of_every_bounce_has_a_dimension_of_its_own) {
  Words depth, which;
  for (std::uint32_t d = 0; d < 4096; ++d)
    for (std::uint32_t w = 0; w < 4; ++w) {
      depth.push_back(d);
      which.push_back(w);
    }
  const Words out = Probe("sampler").run("probe_dimensions", {depth, which}, 1)[0];
  const std::set<std::uint32_t> distinct(out.begin(), out.end());
  EXPECT_EQ(distinct.size(), out.size());
  EXPECT_EQ(*distinct.begin(), 3U) << "the camera's pairs are filter, lens and time";
}

}  // namespace
}  // namespace eikon::test
