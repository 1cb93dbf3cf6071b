// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <vector>

#include "device/profiler.h"
#include "wavefront/tallies.h"

namespace eikon::test {
namespace {

void set(std::uint32_t* words, std::uint64_t ticks) {
  words[0] = std::uint32_t(ticks);
  words[1] = std::uint32_t(ticks >> 32);
}

WorkerTally tally(std::uint64_t begin, std::uint64_t end, std::vector<std::uint64_t> stages) {
  WorkerTally tally{};
  set(tally.begin, begin);
  set(tally.end, end);
  for (std::size_t i = 0; i < stages.size(); ++i) set(tally.ticks + 2 * i, stages[i]);
  return tally;
}

constexpr std::uint64_t kLarge = std::uint64_t{7} << 32;  // beyond one word

TEST(StageShares, are_ticks_over_those_of_all_workers_from_the_first_begin_to_the_last_end) {
  const std::vector<WorkerTally> tallies = {tally(kLarge, kLarge + 800, {100, 300, 0, 200, 150}),
                                            tally(kLarge + 200, kLarge + 1000, {60, 340, 0, 100, 250})};
  const auto shares = stage_shares(tallies);
  EXPECT_EQ(shares.size(), 4U) << "a stage that does not run has none";
  EXPECT_DOUBLE_EQ(shares.at("generate"), 0.08);
  EXPECT_DOUBLE_EQ(shares.at("intersect"), 0.32);
  EXPECT_DOUBLE_EQ(shares.at("shade"), 0.15);
  EXPECT_DOUBLE_EQ(shares.at("shadow"), 0.20);
}

TEST(StageShares, count_more_than_32_bits_of_ticks) {
  const std::vector<WorkerTally> tallies = {tally(1, kLarge + 1, {0, kLarge / 2})};
  EXPECT_DOUBLE_EQ(stage_shares(tallies).at("intersect"), 0.5);
}

TEST(StageShares, are_none_without_a_counter) {
  EXPECT_TRUE(stage_shares({}).empty());
  const std::vector<WorkerTally> tallies = {tally(0, 0, {}), tally(0, 0, {})};
  EXPECT_TRUE(stage_shares(tallies).empty());
}

TEST(Profiler, divides_what_was_recorded_since_the_last_time) {
  Profiler profiler;
  profiler.record("paths", 0, 2, 10, 0);
  profiler.divide("paths", {{"shade", 0.25}, {"shadow", 0.5}});
  profiler.record("paths", 5, 9, 10, 0);
  profiler.divide("paths", {{"shade", 0.5}});
  EXPECT_DOUBLE_EQ(profiler.totals().at("shade").seconds, 2.5);
  EXPECT_DOUBLE_EQ(profiler.totals().at("shade").seconds_min, 0.5);
  EXPECT_DOUBLE_EQ(profiler.totals().at("shade").seconds_max, 2.0);
  EXPECT_DOUBLE_EQ(profiler.totals().at("shadow").seconds, 1.0);
  EXPECT_DOUBLE_EQ(profiler.totals().at("paths").seconds, 2.5) << "the rest";
  EXPECT_EQ(profiler.totals().at("paths").launches, 2U);
  EXPECT_EQ(profiler.totals().at("shade").launches, 0U) << "had none of its own";
}

}  // namespace
}  // namespace eikon::test
