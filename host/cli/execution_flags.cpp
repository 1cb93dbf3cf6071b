// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "accel/accel.h"
#include "cli/flags.h"
#include "wavefront/layout/choose_layout.h"

namespace eikon {

void add_instance_flag(CommandFlags& flags, Execution& execution) {
  flags.choice<InstanceMode>(
      {"--instances", "HOW",
       "store a mesh with several instances once (two-level) or per instance (flat), or auto [auto]"},
      execution.instances,
      {{"auto", InstanceMode::automatic}, {"two-level", InstanceMode::two_level}, {"flat", InstanceMode::flat}});
}

void add_execution_flags(CommandFlags& flags, Execution& execution, bool probe, bool every) {
  flags.group("Devices (the image has the same bits whatever they say)");
  flags.text({"--devices", "LIST", "all, or indices, cpu, gpu, parts of names; cpu:2x1: two devices of one core [all]"},
             execution.devices);
  flags.number({"--threads", "N", "most threads of the host, and most compute units of a CPU device [all allowed]"},
               execution.threads, 1, 65536);
  flags.parsed({"--memory", "SIZE", "most memory of each device, such as 512M or 4G [all allowed]"},
               [&](const std::string& text) { execution.memory_bytes = parse_size_bytes("--memory", text); });
  std::vector<std::string> accels = accelerator_names();
  if (every) accels.emplace_back(kEveryAccelerator);
  flags.choice({"--accel", "NAME", fmt::format("acceleration structure: {} [bvh]", fmt::join(accels, ", "))},
               execution.accel, accels);
  add_instance_flag(flags, execution);
  std::vector<std::string> layouts = tree_layouts();
  if (probe) layouts.emplace_back(kProbeLayouts);
  flags.choice({"--layout", "NAME",
                fmt::format("memory layout of the tree: {}{} [by device]", fmt::join(layouts, ", "),
                            probe ? " (measures all, takes the fastest)" : "")},
               execution.layout, layouts);
}

std::string environment_help() {
  return R"(Environment variables:
  EIKON_OIDN=FILE                 library of Open Image Denoise 2, for --denoise
  EIKON_WATCHDOG=SECONDS          drop a device that hangs this long in a unit of work [10]
  POCL_CACHE_DIR=FOLDER           where PoCL keeps compiled kernels, and eikon programs (in eikon/)
For developers:
  EIKON_KERNEL_DIR=FOLDER         compile these kernels instead of those in the binary
  EIKON_LANES=1|8|16              compile kernels that wide: 1 as for GPUs, 8 or 16 as for CPUs
  EIKON_STAGES=fused|unfused      run all stages of a CPU device in one launch, or each in its own
  EIKON_UNIT_PATHS=N              most paths of a unit of work, 64 to 33554432, on CPUs to 8388608 [by device]
  EIKON_UNIT_BLOCK=N              largest side of the block of pixels of a unit, 1 to 2048 [by device]
  EIKON_NO_OPTIMISE=1             compile kernels without optimisation, as Oclgrind needs
  EIKON_DUMP_PROGRAMS=FOLDER      write each program and its options as the driver's compiler gets them
  EIKON_DIVISION=own|driver       divide in kernels of one lane by eikon's own code or by the driver's [by device]
  EIKON_TICKS=off                 profile as on a processor without a time stamp counter
  EIKON_FAULT=PLAN                make devices fail on purpose; host/device/fault.h explains the plan
)";
}

}  // namespace eikon
