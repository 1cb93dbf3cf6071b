// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "accel/accelerators.h"
#include "cli/arguments.h"
#include "core/error.h"
#include "core/thread_limit.h"
#include "wavefront/layout/choose_layout.h"
#include "pack/settings.h"

namespace eikon {

/// For development, from the environment: EIKON_NO_OPTIMISE=1 compiles the kernels without optimisation, which Oclgrind
/// needs; EIKON_LANES=1, 8 or 16 compiles them that wide, for queues of paths (1) or chunks (8, 16), whatever the device;
/// EIKON_STAGES=fused or unfused runs chunks through all stages in one launch, or each stage in its own;
/// EIKON_WATCHDOG=seconds is how long a device may take for a unit before it is given up, if that is more than 20 times what is
/// expected (default 10); EIKON_TICKS=off leaves the processor's counter alone, as where there is none.
/// Holds the host's own threads to `execution.threads` and to what the process may use, as long as `execution` or a copy lives.
/// throws UsageError
inline void read_execution_environment(Execution& execution) {
  execution.thread_limit = std::make_shared<const ThreadLimit>(execution.threads);
  if (const char* off = std::getenv("EIKON_NO_OPTIMISE")) execution.optimise = std::string(off) != "1";
  if (const char* text = std::getenv("EIKON_LANES")) {
    const std::string lanes = text;
    if (lanes != "1" && lanes != "8" && lanes != "16") throw UsageError("EIKON_LANES=" + lanes + ": takes 1, 8 or 16");
    execution.lanes = std::uint32_t(std::stoul(lanes));
    execution.chunked = lanes != "1";
  }
  if (const char* text = std::getenv("EIKON_STAGES")) {
    const std::string stages = text;
    if (stages != "fused" && stages != "unfused")
      throw UsageError("EIKON_STAGES=" + stages + ": takes fused or unfused");
    execution.fused = stages == "fused";
  }
  if (const char* text = std::getenv("EIKON_WATCHDOG")) {
    char* end = nullptr;
    const double seconds = std::strtod(text, &end);
    if (end == text || *end != '\0' || !(seconds > 0) || seconds > 1e9)
      throw UsageError(std::string("EIKON_WATCHDOG=") + text + ": takes seconds above 0");
    execution.watchdog_s = seconds;
  }
  if (const char* text = std::getenv("EIKON_TICKS")) {
    if (std::string(text) != "off") throw UsageError(std::string("EIKON_TICKS=") + text + ": takes off");
    execution.ticks = false;
  }
}

/// `--accel` takes it beside the names of accelerators in `bench rays`: a table of all.
inline const char* const kEveryAccelerator = "all";

/// --instances. `execution` must outlive the parser.
inline void add_instance_option(CLI::App& command, Execution& execution) {
  static const std::map<std::string, InstanceMode> modes{
      {"auto", InstanceMode::automatic}, {"two-level", InstanceMode::two_level}, {"flat", InstanceMode::flat}};
  command
      .add_option("--instances", execution.instances,
                  "meshes that stand at several places: stored once (two-level) or for each place (flat); auto: once "
                  "where that saves much memory. The image is the same")
      ->transform(CLI::CheckedTransformer(modes))
      ->option_text("TEXT:{auto,flat,two-level}=auto");
}

/// --devices, --threads, --accel, --instances, --layout, --memory; they never change the image. `execution` must outlive the parser.
/// probe: whether --layout takes kProbeLayouts
/// every: whether --accel takes kEveryAccelerator
inline void add_execution_options(CLI::App& command, Execution& execution, bool probe = false, bool every = false) {
  command
      .add_option(
          "--devices", execution.devices,
          "all, or a list of indices, cpu, gpu, parts of names; see `eikon devices`; cpu:2x1 are two devices of "
          "one core each")
      ->capture_default_str();
  command
      .add_option(
          "--threads", execution.threads,
          "at most so many threads of the host, and so many compute units of each CPU device; what the affinity "
          "mask and the control group allow if not given")
      ->check(between(1, 65536));
  std::vector<std::string> accels = accelerator_names();
  if (every) accels.emplace_back(kEveryAccelerator);
  command.add_option("--accel", execution.accel, "how space is searched; bvh, unless another is to be looked at")
      ->check(CLI::IsMember(accels))
      ->capture_default_str();
  add_instance_option(command, execution);
  std::vector<std::string> layouts = tree_layouts();
  if (probe) layouts.emplace_back(kProbeLayouts);
  command
      .add_option("--layout", execution.layout,
                  std::string("of the tree: how it lies in memory; by device if not given") +
                      (probe ? "; probe: the fastest of those measured with the scene's rays" : ""))
      ->check(CLI::IsMember(layouts));
  command
      .add_option(
          "--memory", execution.memory_bytes,
          "at most this much of each device's memory, such as 512M or 4G; all that it has, and that the control "
          "group allows, if not given")
      ->transform(CLI::AsSizeValue(false))
      ->check([](const std::string& bytes) {
        return bytes.find_first_of("123456789") == std::string::npos || bytes[0] == '-'
                   ? "takes a size above 0, such as 512M or 4G, not " + bytes
                   : std::string();
      });
}

}  // namespace eikon
