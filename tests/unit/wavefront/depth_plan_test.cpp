// SPDX-License-Identifier: Apache-2.0
// How many depths are launched at once, for invented units.
#include "wavefront/stages/depth_plan.h"

#include <gtest/gtest.h>

namespace eikon {
namespace {

/// Adds a unit whose paths are halved at each depth. returns  its depths
std::uint32_t add_unit(DepthPlan& plan, std::uint64_t paths) {
  std::uint32_t depths = 0;
  for (; paths > 0; paths /= 2, ++depths) plan.add(paths);
  plan.add(0);
  return depths;
}

TEST(DepthPlan, many_paths_are_looked_at_after_each_depth) {
  DepthPlan plan;
  add_unit(plan, 1U << 22);
  EXPECT_EQ(plan.depths(DepthPlan::kFew + 1, 0), 1U);
  EXPECT_EQ(plan.depths(1U << 22, 1), 1U);
}

TEST(DepthPlan, all_depths_of_the_last_paths_are_launched_at_once) {
  DepthPlan plan;
  for (const std::uint64_t paths : {1U << 22, 5000U}) {
    EXPECT_GE(add_unit(plan, paths), 13U);
    EXPECT_EQ(plan.depths(4096, 0), 13U);
    EXPECT_EQ(plan.depths(4096, 1), 12U) << "one is under way";
    EXPECT_EQ(plan.depths(3, 0), 2U);
    EXPECT_EQ(plan.depths(1, 5), 1U) << "this unit lasts longer";
  }
}

TEST(DepthPlan, counts_of_all_depths_at_once_have_their_places) {
  DepthPlan plan;
  for (int depth = 0; depth < 1000; ++depth) plan.add(7);  // a path between two mirrors
  plan.add(0);
  EXPECT_EQ(plan.depths(7, 0), DepthPlan::kMaxAtOnce);
  EXPECT_LT(DepthPlan::kMaxAtOnce + 1, EK_COUNT_DEPTHS);
}

TEST(DepthPlan, a_unit_that_failed_is_forgotten) {
  DepthPlan plan;
  plan.add(4096);
  plan.restart();
  add_unit(plan, 16);
  EXPECT_EQ(plan.depths(16, 0), 5U);
  EXPECT_LT(plan.depths(4096, 0), 6U);
}

}  // namespace
}  // namespace eikon
