// SPDX-License-Identifier: Apache-2.0
// Decisions about the layout of trees, from plain numbers.
#include "wavefront/layout/choose_layout.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace eikon {
namespace {

TEST(ChooseLayout, the_fastest_wins_if_it_gains_more_than_timing_errs) {
  const LayoutChoice choice = fastest_layout({{"bvh2", 100}, {"bvh4", 140}, {"cwbvh", 130}}, "bvh2");
  EXPECT_EQ(choice.layout, "bvh4");
  EXPECT_EQ(choice.why, "measured, Mrays/s: bvh2 100.0 bvh4 140.0 cwbvh 130.0");
  ASSERT_EQ(choice.rates.size(), 3U);
  EXPECT_EQ(choice.rates[2].mrays_per_s, 130);
  EXPECT_EQ(fastest_layout({{"bvh2", 100}, {"bvh4", 102}}, "bvh2").layout, "bvh2");
  EXPECT_EQ(fastest_layout({{"bvh2", 102}, {"bvh4", 100}}, "bvh4").layout, "bvh4");
  EXPECT_EQ(fastest_layout({{"bvh2", 100}, {"bvh4", 104}}, "bvh2").layout, "bvh4");
  EXPECT_EQ(fastest_layout({{"bvh2", 100}, {"bvh4", 100}}, "bvh4").layout, "bvh4");
}

TEST(ChooseLayout, a_layout_that_could_not_be_measured_is_not_chosen_over_one_that_was) {
  EXPECT_EQ(fastest_layout({{"bvh4", 1}}, "bvh2").layout, "bvh4");
  EXPECT_EQ(fastest_layout({{"bvh2", 0}, {"bvh4", 1}}, "bvh2").layout, "bvh4");
  const LayoutChoice none = fastest_layout({}, "bvh2");
  EXPECT_EQ(none.layout, "bvh2");
  EXPECT_TRUE(none.rates.empty());
}

WavefrontConfig config_of(std::uint32_t lanes, bool chunked, const std::string& layout) {
  WavefrontConfig config;
  config.lanes = lanes, config.chunked = chunked, config.layout = layout;
  return config;
}

bool measures(const WavefrontConfig& config, const std::string& asked, std::size_t triangles, double rays) {
  Execution execution;
  execution.layout = asked;
  const LayoutPlan plan = plan_layout(config, execution, triangles, rays);
  EXPECT_EQ(plan.layout, config.layout);
  return !plan.measure.empty();
}

const double kMinute = 60 * 3e8;  // of rays, at the rate that is assumed

TEST(ChooseLayout, only_long_renders_on_devices_without_a_known_best_layout_are_measured_unasked) {
  const WavefrontConfig gpu = config_of(1, false, "bvh2"), cpu = config_of(16, true, "bvh8");
  EXPECT_TRUE(measures(gpu, "", 1000, kMinute));
  EXPECT_FALSE(measures(cpu, "", 1000, kMinute));
  EXPECT_FALSE(measures(gpu, "", 0, kMinute));  // nothing to trace
  EXPECT_FALSE(measures(gpu, "", 1000, kMinute / 4));
  // Three trees of ten million triangles take half a minute.
  EXPECT_FALSE(measures(gpu, "", 10'000'000, kMinute));
  EXPECT_TRUE(measures(gpu, "", 10'000'000, 10 * kMinute));
}

TEST(ChooseLayout, what_is_asked_for_is_done) {
  const WavefrontConfig gpu = config_of(1, false, "cwbvh");
  EXPECT_FALSE(measures(gpu, "cwbvh", 1000, kMinute));
  EXPECT_TRUE(measures(gpu, kProbeLayouts, 1000, 0));
  EXPECT_FALSE(measures(gpu, kProbeLayouts, 0, kMinute));
  Execution execution;
  execution.layout = "cwbvh";
  EXPECT_EQ(plan_layout(gpu, execution, 1000, 0).why, "asked for");
  EXPECT_EQ(without_probe(execution).layout, "cwbvh");
  execution.layout = kProbeLayouts;
  EXPECT_EQ(without_probe(execution).layout, "");
  EXPECT_EQ(plan_layout(config_of(16, true, "bvh8"), execution, 1000, 0).why, "usual for 16 lanes");
  execution.accel = "none";
  EXPECT_TRUE(plan_layout(config_of(1, false, "none"), execution, 1000, kMinute).measure.empty());
}

TEST(ChooseLayout, nodes_in_vectors_are_measured_where_there_are_lanes_and_the_others_where_there_are_none) {
  Execution execution;
  execution.layout = kProbeLayouts;
  const std::vector<std::string> narrow = plan_layout(config_of(1, false, "bvh2"), execution, 1000, 0).measure;
  EXPECT_EQ(narrow, (std::vector<std::string>{"bvh2", "bvh4", "cwbvh"}));
  for (const std::string& layout : plan_layout(config_of(16, true, "bvh8"), execution, 1000, 0).measure)
    EXPECT_EQ(std::ranges::count(narrow, layout), 0) << layout;
}

}  // namespace
}  // namespace eikon
