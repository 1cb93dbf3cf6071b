// SPDX-License-Identifier: Apache-2.0
// EIKON_FAULT: what it says, and when a fault hits.
#include "device/fault.h"

#include <CL/cl.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/clock.h"

namespace eikon {
namespace {

using Call = Fault::Call;

/// Whether the launch that begins a unit of so many paths fails; the unit's second launch never
/// does.
bool unit_fails(Fault& fault, std::uint64_t paths = 1000) {
  fault.begin_unit(paths);
  const bool fails = fault.at(Call::launch) != CL_SUCCESS;
  EXPECT_EQ(fault.at(Call::launch), CL_SUCCESS);
  return fails;
}

std::vector<bool> units_that_fail(const std::string& text, int units) {
  Fault fault(parse_faults(text));
  std::vector<bool> fails;
  for (int i = 0; i < units; ++i) fails.push_back(unit_fails(fault));
  return fails;
}

TEST(Fault, the_text_says_device_kind_and_when) {
  const std::vector<FaultPlan> plans =
      parse_faults("device:1:after=3;device:0:slow=2.5;device:2:oom:above=100:times=7");
  ASSERT_EQ(plans.size(), 3U);
  EXPECT_EQ(plans[0].device, 1U);
  EXPECT_EQ(plans[0].kind, FaultPlan::Kind::error);
  EXPECT_EQ(plans[0].after, 3U);
  EXPECT_EQ(plans[1].kind, FaultPlan::Kind::slow);
  EXPECT_EQ(plans[1].factor, 2.5);
  EXPECT_EQ(plans[2].kind, FaultPlan::Kind::oom);
  EXPECT_EQ(plans[2].above, 100U);
  EXPECT_EQ(plans[2].times, 7U);
  EXPECT_FALSE(plans[2].after);
}

TEST(Fault, bad_text_is_a_usage_error) {
  for (const char* const bad : {"device",
                                "device:",
                                "device:x",
                                "device:-1",
                                "gpu:1",
                                "device:1:",
                                "device:1:after",
                                "device:1:after=",
                                "device:1:after=x",
                                "device:1:after=-1",
                                "device:1:slow",
                                "device:1:slow=0.5",
                                "device:1:slow=nan",
                                "device:1:slow=1e9",
                                "device:1:explode",
                                "device:1:oom=3",
                                "device:1;",
                                ";",
                                "device:99999999999",
                                "device:1:after=3 "})
    EXPECT_THROW((void)parse_faults(bad), UsageError) << bad;
}

TEST(Fault, units_fail_after_those_that_go_through) {
  EXPECT_EQ(units_that_fail("device:0", 3), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(units_that_fail("device:0:after=2", 4), (std::vector<bool>{false, false, true, true}));
  EXPECT_EQ(units_that_fail("device:0:after=1:times=2", 5), (std::vector<bool>{false, true, true, false, false}));
  EXPECT_EQ(units_that_fail("device:0:oom:after=1", 2), (std::vector<bool>{false, true}));
}

TEST(Fault, only_units_above_a_size_fail) {
  Fault fault(parse_faults("device:0:above=500:oom:after=0"));
  EXPECT_FALSE(unit_fails(fault, 500));
  EXPECT_TRUE(unit_fails(fault, 501));
  EXPECT_FALSE(unit_fails(fault, 250));
}

TEST(Fault, nothing_but_a_unit_s_first_launch_fails) {
  Fault fault(parse_faults("device:0"));
  for (const Call call : {Call::open, Call::allocate, Call::transfer, Call::wait, Call::launch})
    EXPECT_EQ(fault.at(call), CL_SUCCESS);  // before a unit begins
  fault.begin_unit(1);
  EXPECT_EQ(fault.at(Call::transfer), CL_SUCCESS);
  EXPECT_EQ(fault.at(Call::launch), CL_OUT_OF_RESOURCES);
}

TEST(Fault, memory_runs_out_at_allocation) {
  Fault fault(parse_faults("device:0:oom"));
  EXPECT_EQ(fault.at(Call::open), CL_SUCCESS);
  EXPECT_EQ(fault.at(Call::allocate), CL_MEM_OBJECT_ALLOCATION_FAILURE);
}

TEST(Fault, a_device_may_hang_between_units) {
  const std::vector<FaultPlan> plans = parse_faults("device:0:stall:after=3");
  ASSERT_EQ(plans.size(), 1U);
  EXPECT_EQ(plans[0].kind, FaultPlan::Kind::stall);
  EXPECT_EQ(units_that_fail("device:0:stall", 2), (std::vector<bool>{false, false}));
  Fault fault(parse_faults("device:0:stall:after=1"));
  for (const Call call : {Call::open, Call::allocate, Call::transfer, Call::wait, Call::launch, Call::finish})
    EXPECT_EQ(fault.at(call), CL_SUCCESS);
}

TEST(Fault, a_lost_device_stays_lost) {
  Fault at_once(parse_faults("device:0:lost"));
  EXPECT_EQ(at_once.at(Call::open), CL_DEVICE_NOT_AVAILABLE);
  Fault later(parse_faults("device:0:lost:after=1"));
  EXPECT_EQ(later.at(Call::open), CL_SUCCESS);
  EXPECT_FALSE(unit_fails(later));
  later.begin_unit(1);
  EXPECT_EQ(later.at(Call::launch), CL_DEVICE_NOT_AVAILABLE);
  for (const Call call : {Call::open, Call::allocate, Call::transfer, Call::wait, Call::launch})
    EXPECT_EQ(later.at(call), CL_DEVICE_NOT_AVAILABLE);
}

TEST(Fault, a_slow_device_sleeps_for_what_it_lacks) {
  Fault fault(parse_faults("device:0:slow=5;device:0:slow=2"));
  const double begin = host_seconds();
  fault.slow_down(0.01);
  EXPECT_GE(host_seconds() - begin, 0.09);  // ten times as long, of which 0.01 s were busy
}

TEST(Fault, a_wrong_device_changes_what_is_read) {
  std::uint32_t word = 6;
  Fault(parse_faults("device:0:wrong")).spoil(&word, sizeof word);
  EXPECT_EQ(word, 7U);
  Fault(parse_faults("device:0:error")).spoil(&word, sizeof word);
  EXPECT_EQ(word, 7U);
}

}  // namespace
}  // namespace eikon
