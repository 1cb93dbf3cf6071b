// SPDX-License-Identifier: Apache-2.0
// What --devices means, with invented devices.
#include "device/selection.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::error_of;

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
  for (const DeviceInfo& info : resolve_selection(selection, machine()).devices) names.push_back(info.name);
  return names;
}

template <class Wanted>
std::string refusal(const std::string& selection) {
  return error_of<Wanted>([&] { (void)resolve_selection(selection, machine()); });
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
  const std::vector<DeviceInfo> devices = resolve_selection("2,cpu:2x1", machine()).devices;
  ASSERT_EQ(devices.size(), 3U);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(devices[i].position, i);
}

TEST(Selection, a_device_asked_for_by_name_or_index_is_told_from_one_of_a_kind) {
  EXPECT_FALSE(resolve_selection("all", machine()).devices[1].by_name);
  EXPECT_FALSE(resolve_selection("cpu:2x1", machine()).devices[0].by_name);
  EXPECT_TRUE(resolve_selection("1", machine()).devices[0].by_name);
  EXPECT_TRUE(resolve_selection("haswell:1x8", machine()).devices[0].by_name);
  EXPECT_TRUE(resolve_selection("all,1", machine()).devices[1].by_name);
}

TEST(Selection, parts_lie_side_by_side_and_say_where) {
  const std::vector<DeviceInfo> parts = resolve_selection("cpu:2x1+1x4", machine()).devices;
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].name, "Haswell 8 cores [core 1 of 8]");
  EXPECT_EQ(parts[1].name, "Haswell 8 cores [core 2 of 8]");
  EXPECT_EQ(parts[2].name, "Haswell 8 cores [cores 3 to 6 of 8]");
  EXPECT_EQ(parts[2].first_unit, 2U);
  EXPECT_EQ(parts[2].compute_units, 4U);
  EXPECT_FALSE(parts[2].whole());
}

TEST(Selection, a_part_s_selector_chooses_it_alone) {
  for (const DeviceInfo& info : resolve_selection("0,cpu:2x1+1x4", machine()).devices) {
    const std::vector<DeviceInfo> again = resolve_selection(info.selector, machine()).devices;
    ASSERT_EQ(again.size(), 1U) << info.selector;
    EXPECT_EQ(again[0].name, info.name);
    EXPECT_EQ(again[0].first_unit, info.first_unit);
    EXPECT_EQ(again[0].selector, info.selector);
  }
  EXPECT_EQ(resolve_selection("cpu:2x1+1x4/3", machine()).devices[0].first_unit, 2U);
}

TEST(Selection, overlaps_are_refused) {
  EXPECT_TRUE(
      contains(refusal<UsageError>("1,1:2x1"), "'Haswell 8 cores' and 'Haswell 8 cores [core 1 of 8]' overlap"));
  EXPECT_NE(refusal<UsageError>("1:2x4,1:4x2"), "");
  EXPECT_EQ(refusal<UsageError>("1:1x4,1:2x4/2"), "");
}

TEST(Selection, what_a_device_cannot_give_is_refused) {
  EXPECT_TRUE(
      contains(refusal<DeviceError>("cpu:3x3"), "9 compute units are wanted, and device 1 (Haswell 8 cores) has 8"));
  EXPECT_TRUE(contains(refusal<DeviceError>("0:2x1"), "makes no sub-devices"));
  EXPECT_TRUE(contains(refusal<DeviceError>("3"), "0: Big GPU, 1: Haswell 8 cores, 2: Small GPU"));
  EXPECT_NE(refusal<DeviceError>("cpu:2x4294967295"), "");
}

TEST(Selection, what_does_not_parse_is_refused_with_the_entry) {
  for (const char* const bad :
       {"cpu:", "cpu:2", "cpu:x1", "cpu:2x", "cpu:0x1", "cpu:1x0", "cpu:2x1+", "cpu:+2x1", "cpu:-1x1", "cpu:2x1x1",
        "cpu:2 x1", "cpu:1025x1", "cpu:9999999999x1", "cpu:2x1/", "cpu:2x1/0", "cpu:2x1/3", "cpu:2x1/a", "cpu:/1"})
    EXPECT_TRUE(contains(refusal<UsageError>(std::string("0,") + bad), "'" + std::string(bad) + "'")) << bad;
  EXPECT_NE(refusal<DeviceError>(""), "");
  EXPECT_NE(refusal<DeviceError>("0,"), "");
  EXPECT_NE(refusal<DeviceError>(":2x1"), "");
}

DeviceInfo on_platform(DeviceInfo info, const std::string& platform) {
  info.platform = platform;
  return info;
}

TEST(Selection, hardware_is_told_by_kind_address_uuid_or_name) {
  const DeviceInfo cpu = on_platform(device(0, "pthread-EPYC", false, 8), "A");
  const DeviceInfo other = on_platform(device(1, "AMD EPYC", false, 8), "B");
  EXPECT_TRUE(same_hardware(cpu, other));
  DeviceInfo gpu = on_platform(device(2, "Big GPU", true, 40), "A"),
             again = on_platform(device(3, "Mesa Big GPU", true, 40), "B");
  EXPECT_TRUE(same_hardware(gpu, again));
  EXPECT_FALSE(same_hardware(gpu, cpu));
  EXPECT_FALSE(same_hardware(gpu, on_platform(device(4, "Big GPU", true, 40), "A"))) << "two cards of a kind";
  EXPECT_FALSE(same_hardware(gpu, on_platform(device(4, "Small GPU", true, 40), "B")));
  gpu.vendor_id = 7;
  EXPECT_FALSE(same_hardware(gpu, again)) << "another vendor";
  gpu.uuid = again.uuid = "0123";
  EXPECT_TRUE(same_hardware(gpu, again));
  gpu.pci = "0000:01:00.0";
  EXPECT_TRUE(same_hardware(gpu, again)) << "only one knows its address";
  again.pci = "0000:02:00.0";
  EXPECT_FALSE(same_hardware(gpu, again));
}

TEST(Selection, one_processor_under_two_platforms_is_taken_once_by_kind_and_twice_by_index) {
  const std::vector<DeviceInfo> two = {on_platform(device(0, "pthread-EPYC", false, 8), "A"),
                                       on_platform(device(1, "AMD EPYC", false, 8), "B")};
  for (const char* const kind : {"all", "cpu", "cpu:1x8"}) {
    const Selection chosen = resolve_selection(kind, two);
    ASSERT_EQ(chosen.devices.size(), 1U) << kind;
    EXPECT_EQ(chosen.devices[0].index, 0U);
    ASSERT_EQ(chosen.notes.size(), 1U);
    EXPECT_TRUE(contains(chosen.notes[0], "device 1 (AMD EPYC, B) is the hardware of device 0 (A), and is left out"));
  }
  for (const char* const both : {"0,1", "all,1", "epyc"}) {
    const Selection chosen = resolve_selection(both, two);
    EXPECT_EQ(chosen.devices.size(), 2U) << both;
    ASSERT_FALSE(chosen.notes.empty());
    EXPECT_TRUE(contains(chosen.notes.back(), "are one piece of hardware"));
  }
  EXPECT_TRUE(resolve_selection("1", two).notes.empty());
}

TEST(Selection, of_one_piece_of_hardware_the_driver_that_is_right_is_taken) {
  const std::vector<DeviceInfo> two = {on_platform(device(0, "pthread-EPYC", false, 8), "A"),
                                       on_platform(device(1, "AMD EPYC", false, 8), "B")};
  const Selection chosen = resolve_selection("all", two, [](const DeviceInfo& info) { return info.index == 1; });
  ASSERT_EQ(chosen.devices.size(), 1U);
  EXPECT_EQ(chosen.devices[0].index, 1U);
  EXPECT_TRUE(contains(chosen.notes.at(0), "reads memory rightly"));
  const Selection neither = resolve_selection("all", two, [](const DeviceInfo&) { return false; });
  EXPECT_EQ(neither.devices.at(0).index, 0U);
}

TEST(Selection, of_one_piece_of_hardware_the_driver_that_promises_exact_arithmetic_is_taken) {
  std::vector<DeviceInfo> two = {on_platform(device(0, "AMD EPYC", false, 8), "A"),
                                 on_platform(device(1, "pthread-EPYC", false, 8), "B")};
  two[1].correctly_rounded_divide_sqrt = two[1].denormals = true;
  const Selection chosen = resolve_selection("all", two);
  ASSERT_EQ(chosen.devices.size(), 1U);
  EXPECT_EQ(chosen.devices[0].index, 1U);
  EXPECT_TRUE(contains(chosen.notes.at(0), "promises exact arithmetic"));
  const Selection wrong = resolve_selection("all", two, [](const DeviceInfo& info) { return info.index == 0; });
  EXPECT_EQ(wrong.devices.at(0).index, 0U) << "being right counts for more";
}

TEST(Selection, a_cpu_device_is_held_to_what_the_process_may_use) {
  const HostLimits host{4, "affinity mask", 1000, "a file"};
  DeviceInfo cpu = device(0, "CPU", false, 8);
  cpu.memory_bytes = 5000;
  cpu.max_allocation_bytes = 2000;
  DeviceInfo asked = cpu, fits = cpu, gpu = cpu;
  hold_to_limits(cpu, host, 0);
  EXPECT_EQ(cpu.compute_units, 4U);
  EXPECT_EQ(cpu.units_limit, "affinity mask");
  EXPECT_EQ(cpu.memory_bytes, 1000U);
  EXPECT_EQ(cpu.max_allocation_bytes, 1000U);
  EXPECT_EQ(cpu.memory_limit, "a file");
  EXPECT_FALSE(cpu.whole());
  hold_to_limits(asked, host, 3);
  EXPECT_EQ(asked.compute_units, 3U);
  EXPECT_EQ(asked.units_limit, "--threads 3");
  hold_to_limits(fits, {16, "16 processors", 0, ""}, 20);
  EXPECT_EQ(fits.compute_units, 8U);
  EXPECT_EQ(fits.units_limit, "");
  EXPECT_EQ(fits.memory_bytes, 5000U);
  gpu.cpu = false, gpu.gpu = true;
  hold_to_limits(gpu, host, 1);
  EXPECT_EQ(gpu.compute_units, 8U);
  EXPECT_EQ(gpu.memory_bytes, 5000U);
}

TEST(Selection, gpus_of_intel_and_those_that_promise_no_exact_division_divide_by_code_of_their_own) {
  DeviceInfo gpu = device(0, "GPU", true, 4), cpu = device(1, "CPU", false, 4);
  EXPECT_TRUE(divides_itself(gpu, ""));
  EXPECT_FALSE(divides_itself(cpu, ""));
  gpu.correctly_rounded_divide_sqrt = true;
  EXPECT_FALSE(divides_itself(gpu, ""));
  EXPECT_TRUE(divides_itself(gpu, "own"));
  gpu.vendor_id = 0x8086;  // Intel
  EXPECT_TRUE(divides_itself(gpu, ""));
  EXPECT_FALSE(divides_itself(gpu, "driver"));
  EXPECT_THROW((void)divides_itself(gpu, "both"), UsageError);
}

TEST(Selection, a_device_that_cannot_be_used_is_left_out_of_all_and_refused_by_name) {
  std::vector<DeviceInfo> devices = machine();
  devices[0].unusable = "it has no compiler";
  EXPECT_EQ(resolve_selection("all", devices).devices.size(), 2U);
  EXPECT_THROW((void)resolve_selection("0", devices), DeviceError);
}

TEST(Selection, threads_that_feed_other_devices_have_cores_of_their_own) {
  const auto units = [](const std::string& selection, unsigned host_threads) {
    std::vector<DeviceInfo> devices = resolve_selection(selection, machine()).devices;
    const std::vector<std::string> notes = leave_cores_to_feeders(devices, host_threads);
    std::uint32_t cpu_units = 0;
    bool less = false;
    for (const DeviceInfo& info : devices) {
      cpu_units += info.cpu ? info.compute_units : 0;
      less = less || !info.units_limit.empty();
    }
    EXPECT_EQ(notes.empty(), !less);
    return cpu_units;
  };
  EXPECT_EQ(units("cpu", 8), 8U) << "nobody is fed";
  EXPECT_EQ(units("0,1", 8), 7U);
  EXPECT_EQ(units("all", 8), 6U);
  EXPECT_EQ(units("all", 64), 8U) << "there are cores enough";
  EXPECT_EQ(units("all", 2), 1U) << "never none";
  EXPECT_EQ(units("0,cpu:2x4", 8), 8U) << "parts are as they were asked for";
  EXPECT_EQ(units("gpu", 8), 0U);
}

}  // namespace
}  // namespace eikon
