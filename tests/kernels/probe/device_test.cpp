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

namespace eikon {
namespace {

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

TEST(Device, says_which_kernel_cannot_have_the_work_group_that_it_is_to_have) {
  Device device(select_devices("all").front());
  const Program program =
      device.build("kernel void add_one(global uint* words) { words[get_global_id(0)] += 1; }\n", {});
  const Buffer words = device.upload(std::vector<std::uint32_t>(4));
  Arguments arguments;
  arguments.set("words", words);
  Kernel kernel = program.kernel("add_one");
  kernel.bind(arguments);
  const std::size_t most = kernel.most_work_items();
  try {
    device.run(kernel, 1, most + 1);
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    const std::string line = error.what();
    EXPECT_NE(line.find("kernel 'add_one'"), std::string::npos) << line;
    EXPECT_NE(line.find(fmt::format("which takes {};", most)), std::string::npos) << line;
  }
  device.run(kernel, 1, 4);
  EXPECT_EQ(device.read_all<std::uint32_t>(words), std::vector<std::uint32_t>(4, 1));
}

}  // namespace
}  // namespace eikon
