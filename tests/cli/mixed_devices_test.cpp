// SPDX-License-Identifier: Apache-2.0
// Devices of unequal speed, of one driver and of two, on one image: the bits of one device alone.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command.h"

namespace eikon::test {
namespace {

using nlohmann::json;

struct Mixed {
  std::vector<std::uint64_t> units;  // of each device
  std::string names;
};

/// Renders out.exr on the devices, and compares it with one.exr.
Mixed render_mixed(const Workplace& here, const std::string& image, const std::string& devices,
                   const std::string& before) {
  EXPECT_TRUE(succeeded(here.eikon(image + " -o out.exr --stats stats.json --devices " + devices, before)));
  Mixed mixed;
  const json stats = read_json(here / "stats.json");
  for (const json& device : stats.at("devices")) {
    mixed.units.push_back(device.at("units").get<std::uint64_t>());
    mixed.names += device.at("name").get<std::string>() + "; ";
  }
  EXPECT_TRUE(succeeded(here.eikon("compare out.exr one.exr --fail-above 0"))) << devices << ", " << before;
  return mixed;
}

TEST(MixedDevices, N5_three_of_unequal_speed_give_the_bits_of_one) {
  const Workplace here;
  // PoCL's device twice: each has threads of its own.
  const std::string before = "POCL_DEVICES='pthread pthread' POCL_MAX_PTHREAD_COUNT=2";
  const Outcome there = here.eikon("devices", before);
  if (!contains(there.out, "\n1: pthread")) GTEST_SKIP() << "PoCL's device cannot be had twice: " << there.out;
  // Long enough to begin late.
  const std::string image = "render " + scene("cornell_spheres.gltf") + " --size 96x64 --spp 768 --quiet";
  ASSERT_TRUE(succeeded(here.eikon(image + " -o one.exr --devices 0", before)));
  for (const char* faults : {"device:1:slow=2;device:2:slow=4", "device:0:slow=4;device:1:slow=2;device:2:gpu"}) {
    const Mixed mixed = render_mixed(here, image, "0:2x1,1:1x1", before + " EIKON_FAULT='" + faults + "'");
    ASSERT_EQ(mixed.units.size(), 3U);
    for (const std::uint64_t units : mixed.units) EXPECT_GT(units, 0U) << faults;
  }
}

TEST(MixedDevices, N5_three_of_two_drivers_give_the_bits_of_one) {
  const char* const driver = "/usr/lib/oclgrind/liboclgrind-rt-icd.so";
  if (!std::filesystem::exists(driver)) GTEST_SKIP() << "Oclgrind is not installed";
  const Workplace here;
  std::filesystem::create_directory(here / "drivers");
  here.write("drivers/oclgrind.icd", std::string(driver) + "\n");
  for (const auto& entry : std::filesystem::directory_iterator("/etc/OpenCL/vendors"))
    std::filesystem::copy(entry.path(), here / "drivers" / entry.path().filename());
  const std::string before = "OCL_ICD_VENDORS=" + (here / "drivers").string() + " EIKON_NO_OPTIMISE=1";
  const Outcome there = here.eikon("devices", before);
  if (!contains(there.out, "Oclgrind Simulator") || !contains(there.out, "pthread"))
    GTEST_SKIP() << "Oclgrind cannot be had beside PoCL: " << there.out;
  // The two quick ones have work for seconds, so that the simulator compiles and does units
  // meanwhile. They are slowed down, by sleeping, but not to its speed: what the machine loses once
  // would be slept over as many times. A device that hangs is given up long before the test is. On
  // a machine so busy that the simulator comes too late, they get more work.
  const std::string slow = before + " EIKON_WATCHDOG=4 EIKON_FAULT='device:1:slow=20;device:2:slow=20'";
  Mixed mixed;
  for (const char* spp : {"2048", "8192", "32768"}) {
    const std::string image = "render " + scene("cornell.gltf") + " --size 32x32 --max-depth 1 --quiet --spp " + spp;
    ASSERT_TRUE(succeeded(here.eikon(image + " -o one.exr --devices pthread", before)));
    mixed = render_mixed(here, image, "oclgrind,pthread:2x1", slow);
    ASSERT_EQ(mixed.units.size(), 3U) << mixed.names;
    if (std::ranges::find(mixed.units, 0U) == mixed.units.end()) break;
  }
  for (const std::uint64_t units : mixed.units) EXPECT_GT(units, 0U) << mixed.names;
}

}  // namespace
}  // namespace eikon::test
