// SPDX-License-Identifier: Apache-2.0
#include "film/sample_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <set>
#include <tuple>

#include "core/clock.h"
#include "core/error.h"

namespace eikon {
namespace {

WorkUnit unit(Crop block, std::uint64_t begin, std::uint64_t end) { return {block, begin, end}; }

TEST(SampleSet, what_is_missing_of_nothing_is_everything) {
  const SampleSet samples;
  const std::vector<WorkUnit> missing = samples.missing({1, 2, 5, 7}, 3, 9);
  ASSERT_EQ(missing.size(), 1U);
  EXPECT_EQ(missing[0].block, (Crop{1, 2, 5, 7}));
  EXPECT_EQ(missing[0].sample_begin, 3U);
  EXPECT_EQ(missing[0].sample_end, 9U);
  EXPECT_TRUE(samples.empty());
  EXPECT_EQ(samples.sample_count(), 0U);
}

TEST(SampleSet, neighbours_become_one_part) {
  SampleSet samples;
  samples.add(unit({0, 0, 4, 4}, 0, 8));
  samples.add(unit({4, 0, 8, 4}, 0, 4));
  samples.add(unit({0, 4, 8, 8}, 0, 8));
  EXPECT_EQ(samples.parts().size(), 3U);
  samples.add(unit({4, 0, 8, 4}, 4, 8));
  ASSERT_EQ(samples.parts().size(), 1U);
  EXPECT_EQ(samples.parts()[0].block, (Crop{0, 0, 8, 8}));
  EXPECT_EQ(samples.sample_count(), 512U);
  EXPECT_TRUE(samples.missing({0, 0, 8, 8}, 0, 8).empty());
  EXPECT_TRUE(samples.missing({2, 2, 5, 5}, 1, 3).empty());
}

TEST(SampleSet, refuses_what_it_holds) {
  SampleSet samples;
  samples.add(unit({0, 0, 4, 4}, 0, 8));
  const auto twice = samples.overlap(unit({3, 3, 6, 6}, 7, 12));
  ASSERT_TRUE(twice);
  EXPECT_EQ(twice->block, (Crop{3, 3, 4, 4}));
  EXPECT_EQ(twice->sample_begin, 7U);
  EXPECT_EQ(twice->sample_end, 8U);
  EXPECT_THROW(samples.add(unit({3, 3, 6, 6}, 7, 12)), InternalError);
  EXPECT_EQ(samples.sample_count(), 128U);
  EXPECT_FALSE(samples.overlap(unit({4, 0, 6, 4}, 0, 8)));
  EXPECT_FALSE(samples.overlap(unit({0, 0, 4, 4}, 8, 9)));
}

// Against a set of single samples, in random order; the parts depend on the set alone.
TEST(SampleSet, agrees_with_a_plain_set_of_the_samples_of_random_boxes) {
  constexpr std::uint32_t kSide = 6, kSamples = 5;
  using Sample = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>;
  const auto samples_of = [](const std::vector<WorkUnit>& boxes) {
    std::multiset<Sample> samples;
    for (const WorkUnit& b : boxes)
      for (std::uint32_t y = b.block.y0; y < b.block.y1; ++y)
        for (std::uint32_t x = b.block.x0; x < b.block.x1; ++x)
          for (std::uint64_t s = b.sample_begin; s < b.sample_end; ++s) samples.insert({x, y, s});
    return samples;
  };
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t n) { return std::uint32_t(random() % n); };
  for (int round = 0; round < 300; ++round) {
    SampleSet samples;
    std::vector<WorkUnit> added;
    for (int i = 0; i < 12; ++i) {
      const std::uint32_t x = below(kSide), y = below(kSide), s = below(kSamples);
      const WorkUnit box =
          unit({x, y, x + 1 + below(kSide - x), y + 1 + below(kSide - y)}, s, s + 1 + below(kSamples - s));
      const std::multiset<Sample> held = samples_of(added), wanted = samples_of({box});
      const bool clash = std::any_of(wanted.begin(), wanted.end(), [&](const Sample& w) { return held.count(w) > 0; });
      ASSERT_EQ(samples.overlap(box).has_value(), clash);
      if (clash) continue;
      samples.add(box);
      added.push_back(box);
    }
    const std::multiset<Sample> held = samples_of(added);
    ASSERT_EQ(samples_of(samples.parts()), held);
    ASSERT_EQ(samples.sample_count(), held.size());
    const std::multiset<Sample> missing = samples_of(samples.missing({1, 0, 5, 6}, 1, 5));
    std::multiset<Sample> expected;
    for (std::uint32_t y = 0; y < 6; ++y)
      for (std::uint32_t x = 1; x < 5; ++x)
        for (std::uint64_t s = 1; s < 5; ++s)
          if (held.count({x, y, s}) == 0) expected.insert({x, y, s});
    ASSERT_EQ(missing, expected);
    SampleSet other;
    std::shuffle(added.begin(), added.end(), random);
    for (const WorkUnit& box : added) other.add(box);
    ASSERT_TRUE(samples == other);
  }
}

// The parts of merged files are read in the order of parts(). With eight times as many of them,
// steps that go through all parts take 64 times as long. A busy machine may make any attempt slow,
// but not all of them.
TEST(SampleSet, takes_parts_in_order_without_going_through_all_before) {
  constexpr std::uint32_t kFew = 1000, kMany = 8 * kFew;
  const std::function<WorkUnit(std::uint32_t)> orders[] = {
      [](std::uint32_t i) {
        return unit({0, 0, 4, 4}, std::uint64_t{2} * i, std::uint64_t{2} * i + 1);
      },
      [](std::uint32_t i) {
        return unit({i, 0, i + 1, 4}, i % 2, i % 2 + 1);
      },
      [](std::uint32_t i) {
        return unit({0, i, 4, i + 1}, i % 2, i % 2 + 1);
      }};
  for (const auto& part : orders) {
    const auto seconds_of = [&](std::uint32_t count) {
      const double begin_s = host_seconds();
      SampleSet set;
      for (std::uint32_t i = 0; i < count; ++i)
        if (!set.overlap(part(i))) set.add(part(i));
      const double end_s = host_seconds();
      EXPECT_EQ(set.parts().size(), count);
      return end_s - begin_s;
    };
    double ratio = 64;
    for (int attempt = 0; attempt < 5 && ratio > 24; ++attempt) ratio = seconds_of(kMany) / seconds_of(kFew);
    EXPECT_LE(ratio, 24) << "at " << part(1).block.x0 << "," << part(1).block.y0;
  }
}

}  // namespace
}  // namespace eikon
