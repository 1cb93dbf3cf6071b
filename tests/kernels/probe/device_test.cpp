// SPDX-License-Identifier: Apache-2.0
// One device opened many times in one process, by several threads, whole and in parts.
#include "device/device.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <atomic>
#include <thread>
#include <vector>

#include "core/error.h"
#include "device/probes.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::message_of;

TEST(Device, can_be_opened_many_times_from_several_threads) {
  const DeviceInfo info = select_devices("all").front();
  std::atomic<int> right{0};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i)
      threads.emplace_back([&] {
        for (int round = 0; round < 3; ++round) right += passes_canary(info) ? 1 : 0;
      });
  }
  EXPECT_EQ(right, 12);
}

TEST(Device, parts_are_devices) {
  const DeviceInfo whole = select_devices("all").front();
  if (!whole.divisible || whole.compute_units < 2) GTEST_SKIP() << whole.name << " cannot be divided";
  std::atomic<int> right{0};
  {
    std::vector<std::jthread> threads;
    for (const DeviceInfo& part : select_devices(whole.selector + ":2x1"))
      threads.emplace_back([&, part] {
        for (int round = 0; round < 3; ++round) right += passes_canary(part) ? 1 : 0;
      });
  }
  EXPECT_EQ(right, 6);
}

TEST(Device, notes_times_only_if_they_are_wanted) {
  DeviceInfo info = select_devices("all").front();
  std::vector<std::uint32_t> words(1U << 20), copy(words.size());
  for (const bool timed : {true, false}) {
    info.timed = timed;
    Device device(info);
    device.read(device.upload(words.data(), 4 * words.size()), copy.data(), 4 * copy.size());
    const auto& totals = device.profiler().totals();
    for (const char* name : {"upload", "read back"}) {
      const StageTotals& stage = totals.at(name);
      EXPECT_EQ(stage.launches, 1U) << name;
      EXPECT_EQ(stage.bytes, 4 * words.size()) << name;
      EXPECT_EQ(stage.seconds > 0, timed) << name;
    }
    EXPECT_EQ(device.profiler().gaps().launches, timed ? 1U : 0U);
  }
}

constexpr const char* kAddOne = "kernel void add_one(global uint* words) { words[get_global_id(0)] += 1; }\n";

/// A kernel that adds one to each of some words.
Kernel add_one_to(Device& device, const Buffer& words) {
  Arguments arguments;
  arguments.set("words", words);
  Kernel kernel = device.build(kAddOne, {}).kernel("add_one");
  kernel.bind(arguments);
  return kernel;
}

TEST(Device, counts_what_has_ended_also_while_a_transfer_beside_it_is_under_way) {
  DeviceInfo info = select_devices("all").front();
  info.cpu = false, info.gpu = true;  // so that it has a queue for transfers beside the work
  Device device(info);
  const Buffer large = device.allocate(std::size_t{64} << 20), small = device.upload(std::vector<std::uint32_t>(4));
  const Kernel kernel = add_one_to(device, small);
  std::vector<std::uint32_t> copy(large.size_bytes() / 4), words(4);
  device.fill_zero(large);
  device.finish();
  for (std::uint32_t round = 1; round <= 8; ++round) {
    device.run(kernel, 1, 1);
    const Ticket beside = device.read_beside(large, copy.data(), 4 * copy.size());
    device.run(kernel, 1, 1);
    const Ticket last = device.read_later(small, words.data(), 4 * words.size());
    device.run(kernel, 1, 1);
    device.wait(last);
    EXPECT_EQ(device.profiler().totals().at("add_one").launches, 3 * round - 1) << "those before the transfer";
    device.wait(beside);
    device.finish();
    EXPECT_EQ(device.profiler().totals().at("add_one").launches, 3 * round);
    EXPECT_EQ(device.profiler().totals().at("read back").launches, 2 * round);
  }
}

TEST(Device, says_which_kernel_cannot_have_the_work_group_that_it_is_to_have) {
  Device device(select_devices("all").front());
  const Buffer words = device.upload(std::vector<std::uint32_t>(4));
  const Kernel kernel = add_one_to(device, words);
  const std::size_t most = kernel.most_work_items();
  const std::string line = message_of<DeviceError>([&] { device.run(kernel, 1, most + 1); });
  EXPECT_TRUE(contains(line, "kernel 'add_one'"));
  EXPECT_TRUE(contains(line, fmt::format("which takes {};", most)));
  device.run(kernel, 1, 4);
  EXPECT_EQ(device.read_all<std::uint32_t>(words), std::vector<std::uint32_t>(4, 1));
}

}  // namespace
}  // namespace eikon
