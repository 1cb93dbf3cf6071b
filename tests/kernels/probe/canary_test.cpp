// SPDX-License-Identifier: Apache-2.0
// The memory probe that a device must pass before a render trusts it.

#include <gtest/gtest.h>

#include "device/fault.h"
#include "device/kernel_sources.h"
#include "device/probes.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::error_of;

/// What require_canary throws on a device that runs `text`, or "".
std::string refusal(Device& device, const std::string& text, const char* lanes) {
  ProgramOptions options;
  options.optimise = device.info().platform.find("Oclgrind") == std::string::npos;
  options.defines["EK_WIDTH"] = lanes;
  return error_of<UntrustedDevice>([&] { require_canary(device, device.build(text, options)); });
}

TEST(Canary, every_device_passes_at_every_width) {
  for (const DeviceInfo& info : list_devices()) {
    Device device(info);
    for (const char* const lanes : {"1", "8", "16"})
      EXPECT_EQ(refusal(device, kernel_text({"probe/canary.cl"}), lanes), "") << info.name << ", " << lanes << " lanes";
  }
}

TEST(Canary, a_driver_that_reads_element_0_at_every_offset_is_told) {
  // Each way of reading, broken on its own.
  const char* const broken[][3] = {{"1", "gather_u(global const uint* p, vu i) { return p[i]; }",
                                    "gather_u(global const uint* p, vu i) { return p[0]; }"},
                                   {"1", "gather_f(global const float* p, vu i) { return p[i]; }",
                                    "gather_f(global const float* p, vu i) { return p[0]; }"},
                                   {"1", "records + (size_t)i * 16", "records + (size_t)i * 0"},
                                   {"16", "(p + (size_t)i.s##lane * 16)", "(p + (size_t)i.s##lane * 0)"},
                                   {"8", "[round * 1021u + 5u].flags", "[0].flags"}};
  Device device(select_devices("all").front());
  for (const auto& [lanes, right, wrong] : broken) {
    std::string text = kernel_text({"probe/canary.cl"});
    const std::size_t at = text.find(right);
    ASSERT_NE(at, std::string::npos) << right;
    const std::string found = refusal(device, text.replace(at, std::string(right).size(), wrong), lanes);
    EXPECT_TRUE(contains(found, "is not to be trusted")) << wrong;
    EXPECT_FALSE(contains(found, "\n"));
  }
}

TEST(Canary, what_comes_back_wrong_is_told) {
  DeviceInfo info = select_devices("all").front();
  EXPECT_TRUE(passes_canary(info));
  info.fault = std::make_shared<Fault>(parse_faults("device:0:wrong"));
  EXPECT_FALSE(passes_canary(info));
}

}  // namespace
}  // namespace eikon
