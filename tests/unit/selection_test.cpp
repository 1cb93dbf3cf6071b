// SPDX-License-Identifier: Apache-2.0
// What --devices means, with invented devices.
#include "device/selection.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace eikon {
namespace {

DeviceInfo device(std::uint32_t index, const std::string& name, bool gpu, std::uint32_t units) {
  DeviceInfo info;
  info.index = index;
  info.name = name;
  info.gpu = gpu;
  info.cpu = !gpu;
  info.compute_units = info.whole_units = units;
  info.divisible = !gpu;
  info.selector = std::to_string(index);
  return info;
}

std::vector<DeviceInfo> machine() {
  return {device(0, "Big GPU", true, 40), device(1, "Haswell 8 cores", false, 8), device(2, "Small GPU", true, 4)};
}

std::vector<std::string> chosen(const std::string& selection) {
  std::vector<std::string> names;
  for (const DeviceInfo& info : resolve_selection(selection, machine())) names.push_back(info.name);
  return names;
}

/// The error's message, or "" when there is none of that type.
template <class Wanted>
std::string refusal(const std::string& selection) {
  try {
    (void)resolve_selection(selection, machine());
  } catch (const Wanted& error) {
    return error.what();
  }
  return "";
}

using Names = std::vector<std::string>;

TEST(Selection, names_kinds_indices_and_parts_of_names) {
  EXPECT_EQ(chosen("all"), (Names{"Big GPU", "Haswell 8 cores", "Small GPU"}));
  EXPECT_EQ(chosen("gpu"), (Names{"Big GPU", "Small GPU"}));
  EXPECT_EQ(chosen("cpu"), (Names{"Haswell 8 cores"}));
  EXPECT_EQ(chosen("2,0"), (Names{"Small GPU", "Big GPU"}));
  EXPECT_EQ(chosen("haswell,small"), (Names{"Haswell 8 cores", "Small GPU"}));
}

TEST(Selection, what_is_named_twice_is_there_once) {
  EXPECT_EQ(chosen("0,0"), (Names{"Big GPU"}));
  EXPECT_EQ(chosen("gpu,all,0"), (Names{"Big GPU", "Small GPU", "Haswell 8 cores"}));
  EXPECT_EQ(chosen("cpu:2x1,1:1x1").size(), 2U);
}

TEST(Selection, positions_count_what_was_chosen) {
  const std::vector<DeviceInfo> devices = resolve_selection("2,cpu:2x1", machine());
  ASSERT_EQ(devices.size(), 3U);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(devices[i].position, i);
}

TEST(Selection, a_device_asked_for_by_name_or_index_is_told_from_one_of_a_kind) {
  EXPECT_FALSE(resolve_selection("all", machine())[1].by_name);
  EXPECT_FALSE(resolve_selection("cpu:2x1", machine())[0].by_name);
  EXPECT_TRUE(resolve_selection("1", machine())[0].by_name);
  EXPECT_TRUE(resolve_selection("haswell:1x8", machine())[0].by_name);
  EXPECT_TRUE(resolve_selection("all,1", machine())[1].by_name);
}

TEST(Selection, parts_lie_side_by_side_and_say_where) {
  const std::vector<DeviceInfo> parts = resolve_selection("cpu:2x1+1x4", machine());
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].name, "Haswell 8 cores [core 1 of 8]");
  EXPECT_EQ(parts[1].name, "Haswell 8 cores [core 2 of 8]");
  EXPECT_EQ(parts[2].name, "Haswell 8 cores [cores 3 to 6 of 8]");
  EXPECT_EQ(parts[2].first_unit, 2U);
  EXPECT_EQ(parts[2].compute_units, 4U);
  EXPECT_FALSE(parts[2].whole());
}

TEST(Selection, a_part_s_selector_chooses_it_alone) {
  for (const DeviceInfo& info : resolve_selection("0,cpu:2x1+1x4", machine())) {
    const std::vector<DeviceInfo> again = resolve_selection(info.selector, machine());
    ASSERT_EQ(again.size(), 1U) << info.selector;
    EXPECT_EQ(again[0].name, info.name);
    EXPECT_EQ(again[0].first_unit, info.first_unit);
    EXPECT_EQ(again[0].selector, info.selector);
  }
  EXPECT_EQ(resolve_selection("cpu:2x1+1x4/3", machine())[0].first_unit, 2U);
}

TEST(Selection, overlaps_are_refused) {
  EXPECT_NE(refusal<UsageError>("1,1:2x1").find("'Haswell 8 cores' and 'Haswell 8 cores [core 1 of 8]' overlap"),
            std::string::npos);
  EXPECT_NE(refusal<UsageError>("1:2x4,1:4x2"), "");
  EXPECT_EQ(refusal<UsageError>("1:1x4,1:2x4/2"), "");
}

TEST(Selection, what_a_device_cannot_give_is_refused) {
  EXPECT_NE(refusal<DeviceError>("cpu:3x3").find("9 compute units are wanted, and device 1 (Haswell 8 cores) has 8"),
            std::string::npos);
  EXPECT_NE(refusal<DeviceError>("0:2x1").find("makes no sub-devices"), std::string::npos);
  EXPECT_NE(refusal<DeviceError>("3").find("0: Big GPU, 1: Haswell 8 cores, 2: Small GPU"), std::string::npos);
  EXPECT_NE(refusal<DeviceError>("cpu:2x4294967295"), "");
}

TEST(Selection, what_does_not_parse_is_refused_with_the_entry) {
  for (const char* const bad :
       {"cpu:", "cpu:2", "cpu:x1", "cpu:2x", "cpu:0x1", "cpu:1x0", "cpu:2x1+", "cpu:+2x1", "cpu:-1x1", "cpu:2x1x1",
        "cpu:2 x1", "cpu:1025x1", "cpu:9999999999x1", "cpu:2x1/", "cpu:2x1/0", "cpu:2x1/3", "cpu:2x1/a", "cpu:/1"})
    EXPECT_NE(refusal<UsageError>(std::string("0,") + bad).find("'" + std::string(bad) + "'"), std::string::npos)
        << bad;
  EXPECT_NE(refusal<DeviceError>(""), "");
  EXPECT_NE(refusal<DeviceError>("0,"), "");
  EXPECT_NE(refusal<DeviceError>(":2x1"), "");
}

TEST(Selection, a_device_that_cannot_be_used_is_left_out_of_all_and_refused_by_name) {
  std::vector<DeviceInfo> devices = machine();
  devices[0].unusable = "it has no compiler";
  EXPECT_EQ(resolve_selection("all", devices).size(), 2U);
  EXPECT_THROW((void)resolve_selection("0", devices), DeviceError);
}

}  // namespace
}  // namespace eikon
