// SPDX-License-Identifier: Apache-2.0
// The dialect itself: what moves lanes about. That all widths agree is checked for every probe
// (probe.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "kernels/probe.h"

namespace eikon::test {
namespace {

TEST(Lanes, compaction_keeps_the_set_lanes_in_order) {
  std::mt19937 random(1);
  for (const double density : {0.0, 0.03, 0.5, 0.97, 1.0}) {
    Words flags(4096), values(4096), expected;
    for (std::size_t i = 0; i < flags.size(); ++i) {
      flags[i] = std::bernoulli_distribution(density)(random) ? std::uint32_t(random()) | 1U : 0U;
      values[i] = std::uint32_t(random());
      if (flags[i] != 0) expected.push_back(values[i]);
    }
    expected.resize(flags.size(), 0);
    EXPECT_EQ(Probe("lanes").run("probe_compaction", {flags, values}, 1)[0], expected) << density;
  }
}

TEST(Lanes, every_pattern_of_eight_lanes_compacts_rightly_in_either_half) {
  Words flags, values, expected;
  for (std::uint32_t pattern = 0; pattern < 512; ++pattern)
    for (std::uint32_t lane = 0; lane < 16; ++lane) {
      const bool set =
          pattern < 256 ? lane < 8 && ((pattern >> lane) & 1U) != 0 : lane >= 8 && ((pattern >> (lane - 8)) & 1U) != 0;
      flags.push_back(set ? 1 : 0);
      values.push_back(pattern * 16 + lane + 1);
      if (set) expected.push_back(values.back());
    }
  expected.resize(flags.size(), 0);
  EXPECT_EQ(Probe("lanes").run("probe_compaction", {flags, values}, 1)[0], expected);
}

TEST(Lanes, any_sees_every_lane) {
  Words flags(16 * 16, 0), expected(16 * 16, 0);
  for (std::size_t group = 1; group < 16; ++group)
    for (std::size_t lane = 0; lane < 16; ++lane) flags[group * 16 + lane] = expected[group * 16 + lane] = 1;
  EXPECT_EQ(Probe("lanes").run("probe_any", {flags}, 1)[0], expected);
}

TEST(Lanes, whole_records_arrive_transposed) {
  constexpr std::uint32_t kRecords = 1000;
  Words records(kRecords * 16);
  std::iota(records.begin(), records.end(), 0x3f800000U);  // ordinary floats: all bits must survive
  records[5 * 16 + 3] = 0x7fc12345U;                       // and those of integers that look like NaN
  records[5 * 16 + 4] = 0x00000001U;                       // or like denormals
  std::mt19937 random(2);
  Words index(2048);
  for (auto& i : index) i = std::uint32_t(random()) % kRecords;
  index[0] = 5;
  const auto out = Probe("lanes").buffer("records", records).run("probe_records", {index}, 16);
  for (std::size_t i = 0; i < index.size(); ++i)
    for (std::size_t w = 0; w < 16; ++w)
      ASSERT_EQ(out[w][i], records[index[i] * 16 + w]) << "item " << i << ", word " << w;
}

TEST(Lanes, gather_and_scatter_address_each_lane_on_its_own) {
  constexpr std::uint32_t kItems = 1024;
  std::mt19937 random(3);
  Words from(kItems), to(kItems), values(kItems), expected(kItems), gathered(kItems), index(kItems);
  std::iota(to.begin(), to.end(), 0U);
  std::shuffle(to.begin(), to.end(), random);
  for (std::uint32_t i = 0; i < kItems; ++i) {
    from[i] = std::uint32_t(random()) % kItems;
    values[i] = std::uint32_t(random()) & 0x7effffffU;
    index[i] = i;
  }
  for (std::uint32_t i = 0; i < kItems; ++i) expected[to[i]] = gathered[i] = values[from[i]];
  const auto out = Probe("lanes").run("probe_gather_scatter", {from, to, values}, 3);
  EXPECT_EQ(out[0], expected);
  EXPECT_EQ(out[1], gathered);
  EXPECT_EQ(out[2], index);
}

}  // namespace
}  // namespace eikon::test
