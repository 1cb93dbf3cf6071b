// SPDX-License-Identifier: Apache-2.0
// --devices: sub-devices, and what cannot be had; faults on purpose (EIKON_FAULT).
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <utility>

#include "cli/command.h"

namespace eikon {
namespace {

using namespace eikon::test;
using nlohmann::json;

const char* const kCores = "POCL_MAX_PTHREAD_COUNT=2";  // of PoCL's device, wherever the tests run

TEST(Devices, two_cores_are_two_devices_and_give_the_bits_of_the_whole) {
  const Workplace here;
  const std::string image = "render " + scene("cornell.gltf") + " --size 200x200 --spp 64 --quiet ";
  ASSERT_TRUE(succeeded(here.eikon(image + "-o whole.exr --devices 0", kCores)));
  const Outcome parts = here.eikon(image + "-o parts.exr --stats stats.json --devices cpu:2x1", kCores);
  ASSERT_TRUE(succeeded(parts));
  const json devices = read_json(here / "stats.json").at("devices");
  ASSERT_EQ(devices.size(), 2U);
  for (const json& device : devices) EXPECT_GT(device.at("units").get<int>(), 0);
  EXPECT_TRUE(contains(devices[0].at("name").get<std::string>(), "[core 1 of 2]"));
  EXPECT_TRUE(contains(devices[1].at("name").get<std::string>(), "[core 2 of 2]"));
  EXPECT_TRUE(succeeded(here.eikon("compare parts.exr whole.exr --fail-above 0")));
}

TEST(Devices, N5_three_devices_of_unequal_speed_some_of_which_fail_give_the_bits_of_one) {
  const Workplace here;
  const std::string three = "POCL_DEVICES='pthread pthread pthread' ";  // of one piece of hardware, which is said
  const std::string image = "render " + scene("cornell.gltf") + " --size 96x64 --spp 24 --quiet ";
  if (here.eikon("devices", three).out.find("\n2: ") == std::string::npos) GTEST_SKIP() << "no driver that divides so";
  ASSERT_TRUE(succeeded(here.eikon(image + "-o one.exr --devices 0")));
  for (const char* fault : {"device:1:slow=3;device:2:slow=10", "device:0:after=2;device:2:slow=5",
                            "device:0:after=1:times=1;device:1:lost;device:2:after=3:oom"}) {
    EXPECT_TRUE(succeeded(here.eikon(image + "-o three.exr --devices 0,1,2", three + "EIKON_FAULT='" + fault + "'")));
    EXPECT_TRUE(succeeded(here.eikon("compare three.exr one.exr --fail-above 0"))) << fault;
  }
}

TEST(Devices, partitions_that_cannot_be_are_refused_in_a_line) {
  const Workplace here;
  const auto refused_with = [&](const std::string& devices, int code, const std::string& why) {
    const Outcome outcome = here.eikon(cornell("--devices " + devices), kCores);
    EXPECT_TRUE(refused(outcome, code)) << devices;
    EXPECT_TRUE(contains(outcome.err, why));
  };
  refused_with("cpu:3x1", 4, "3 compute units are wanted");
  refused_with("cpu:2y1", 2, "'2y1'");
  refused_with("0:1x1,0", 2, "overlap");
  refused_with("cpu:2x1/3", 2, "has 2 parts");
  EXPECT_TRUE(here.files().empty());
}

/// Processor seconds and wall seconds of a run.
struct Times {
  double processor_s = 0, wall_s = 0;
};
Times times_of(const Workplace& here, const std::string& arguments, const std::string& before = "") {
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = here.start(arguments, before);
  int status = 0;
  rusage usage{};
  EXPECT_EQ(wait4(child, &status, 0, &usage), child);
  EXPECT_EQ(status, 0);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime),
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
}

TEST(Devices, a_folder_for_compiled_kernels_that_cannot_be_made_is_named) {
  const Workplace here;
  here.write("file", "");
  for (const char* variable : {"POCL_CACHE_DIR=$PWD/file/cache", "-u POCL_CACHE_DIR XDG_CACHE_HOME=$PWD/file"})
    for (const std::string& command : {std::string("devices"), cornell()}) {
      const Outcome outcome = here.eikon(command, variable);
      EXPECT_TRUE(refused(outcome, kDevice)) << variable << " " << command;
      EXPECT_TRUE(contains(outcome.err, "file/") && contains(outcome.err, "Not a directory; set POCL_CACHE_DIR"))
          << outcome.err;
    }
}

TEST(Devices, a_file_in_place_of_the_folder_for_compiled_kernels_is_named) {
  // PoCL has a device then, and compiles nothing.
  const Workplace here;
  here.write("file", "");
  for (const char* variables : {"POCL_CACHE_DIR=$PWD/file", "POCL_CACHE_DIR=$PWD/file POCL_KERNEL_CACHE=0"}) {
    const Outcome outcome = here.eikon(cornell(), variables);
    EXPECT_TRUE(refused(outcome, kDevice)) << variables;
    EXPECT_TRUE(contains(outcome.err, "PoCL cannot keep compiled kernels in")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "Not a directory; set POCL_CACHE_DIR")) << outcome.err;
  }
}

TEST(Devices, a_folder_of_kernels_without_them_is_a_wrong_variable) {
  const Workplace here;
  const Outcome outcome = here.eikon(cornell(), "EIKON_KERNEL_DIR=/nowhere");
  EXPECT_TRUE(refused(outcome, kUsage));
  EXPECT_TRUE(contains(outcome.err, "EIKON_KERNEL_DIR=/nowhere: "));
}

TEST(Devices, one_thread_is_one_busy_core) {
  const Workplace here;
  const std::string image = cornell("--size 128x128 --spp 64 --quiet ");
  ASSERT_TRUE(succeeded(here.eikon(image)));  // compiles
  for (const auto& [flags, before] : {std::pair("--threads 1", kCores), {"", "taskset -c 0"}}) {
    const Times times = times_of(here, image + flags, before);
    EXPECT_LT(times.processor_s, 1.05 * times.wall_s) << flags << before;
  }
}

TEST(Devices, limits_that_hold_are_said_and_why) {
  const Workplace here;
  const Outcome pinned = here.eikon("devices", std::string(kCores) + " taskset -c 0");
  ASSERT_TRUE(succeeded(pinned));
  if (std::thread::hardware_concurrency() > 1) {
    EXPECT_TRUE(contains(pinned.out, "1 of 2 compute units (affinity mask of 1 of "));
    EXPECT_TRUE(contains(pinned.out, "host: 1 threads (affinity mask of 1 of "));
  }
  EXPECT_TRUE(refused(here.eikon(cornell("--threads 1 --devices cpu:2x1"), kCores), 4));
  for (const char* const bad : {"0", "-1", "many", ""})
    EXPECT_TRUE(refused(here.eikon(cornell(std::string("--threads '") + bad + "'")), 2)) << bad;
}

TEST(Devices, a_fault_on_purpose_hits_the_device_of_that_position) {
  const Workplace here;
  const auto with_fault = [&](const std::string& fault, const std::string& devices) {
    return here.eikon(cornell("--size 64x64 --spp 4 --quiet --devices " + devices), "EIKON_FAULT='" + fault + "'");
  };
  EXPECT_TRUE(refused(with_fault("device:0:lost", "0"), 4));
  EXPECT_TRUE(refused(with_fault("device:0:oom", "0"), 4));
  EXPECT_TRUE(refused(with_fault("device:0", "0"), 4));
  EXPECT_TRUE(succeeded(with_fault("device:0:after=1000", "0")));
  EXPECT_TRUE(succeeded(with_fault("device:1:lost", "0")));
  EXPECT_TRUE(refused(with_fault("device:0:explode", "0"), 2));
  const Outcome wrong = with_fault("device:0:wrong", "0");
  EXPECT_TRUE(refused(wrong, 4));
  EXPECT_TRUE(contains(wrong.err, "not to be trusted"));
}

TEST(Devices, that_divide_by_code_of_their_own_give_the_same_bits) {
  const Workplace here;
  for (const char* name : {"cornell_spheres", "textured"}) {
    const std::string image = "render " + scene(std::string(name) + ".gltf") + " --size 24x16 --spp 4 --quiet ";
    ASSERT_TRUE(succeeded(here.eikon(image + "-o driver.exr")));
    const auto programs = here / name;
    std::filesystem::create_directory(programs);
    ASSERT_TRUE(succeeded(here.eikon(
        image + "-o own.exr",
        "EIKON_LANES=1 EIKON_FAULT=device:0:gpu EIKON_DIVISION=own EIKON_DUMP_PROGRAMS=" + programs.string())));
    EXPECT_TRUE(succeeded(here.eikon("compare own.exr driver.exr --fail-above 0"))) << name;
    std::ostringstream options;
    options << std::ifstream(programs / "program_0.options").rdbuf();
    EXPECT_TRUE(contains(options.str(), " -DEK_OWN_DIVISION=1")) << options.str();
  }
  EXPECT_TRUE(contains(here.eikon("devices", "EIKON_LANES=1 EIKON_DIVISION=own").out,
                       "divide and square root by eikon's own code"));
  EXPECT_FALSE(contains(here.eikon("devices", "EIKON_DIVISION=own").out, "own code"));  // of several lanes
  EXPECT_TRUE(refused(here.eikon("devices", "EIKON_DIVISION=both"), 2));
}

TEST(Units, N5_of_the_size_that_the_environment_asks_for_give_the_same_bits) {
  const Workplace here;
  const std::string image = cornell("--size 256x256 --spp 16 --max-depth 2 --quiet --devices 0 --stats stats.json");
  const auto units_of = [&](const std::string& variables) {
    EXPECT_TRUE(succeeded(here.eikon(image, "EIKON_LANES=1 EIKON_FAULT=device:0:gpu " + variables))) << variables;
    return read_json(here / "stats.json").at("devices").at(0).at("units").get<int>();
  };
  EXPECT_GE(units_of("EIKON_UNIT_BLOCK=16"), 256);
  std::filesystem::rename(here / "out.exr", here / "small.exr");
  EXPECT_LT(units_of("EIKON_UNIT_BLOCK=256"), 64);  // of up to 65536 pixels
  EXPECT_TRUE(succeeded(here.eikon("compare out.exr small.exr --fail-above 0")));
  EXPECT_GE(units_of("EIKON_UNIT_PATHS=4096"), 256);
  EXPECT_TRUE(succeeded(here.eikon("compare out.exr small.exr --fail-above 0")));
  for (const char* bad :
       {"PATHS=63", "PATHS=33554433", "PATHS=-1", "PATHS=many", "PATHS=", "BLOCK=0", "BLOCK=2049", "BLOCK=8x8"})
    EXPECT_TRUE(refused(here.eikon(image, std::string("EIKON_UNIT_") + bad), kUsage)) << bad;
}

TEST(Programs, are_dumped_as_the_driver_gets_them) {
  const Workplace here;
  std::filesystem::create_directory(here / "programs");
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + " -o out.exr --size 8x8 --spp 1 --quiet",
                                   "EIKON_DUMP_PROGRAMS=programs EIKON_LANES=1 EIKON_FAULT=device:0:gpu")));
  const std::string text = read_bytes(here / "programs/program_0.cl");
  const std::string options = read_bytes(here / "programs/program_0.options");
  for (const char* kernel : {"intersect", "shade", "compact", "shadow", "film"})
    EXPECT_TRUE(contains(text, std::string("kernel void ") + kernel + "(")) << kernel;
  for (const char* option : {"-cl-std=CL1.2 ", " -DEK_WIDTH=1", " -DEK_CHUNKED=0 ", " -DEK_LAYOUT_bvh2=1 "})
    EXPECT_TRUE(contains(options, option)) << option;
  const Outcome nowhere = here.eikon("render " + scene("cornell.gltf") + " -o out.exr --size 8x8 --spp 1 --quiet",
                                     "EIKON_DUMP_PROGRAMS=missing");
  EXPECT_EQ(nowhere.code, 3);
  EXPECT_TRUE(contains(nowhere.err, "name a folder that is there"));
}

}  // namespace
}  // namespace eikon
