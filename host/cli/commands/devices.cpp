// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "cli/commands.h"
#include "core/host_limits.h"
#include "device/device.h"
#include "device/probes.h"
#include "wavefront/wavefront.h"

namespace eikon {
namespace {

std::string gibibytes(std::uint64_t bytes) { return fmt::format("{:.1f} GiB", double(bytes) / (1U << 30)); }

std::string limit_of(const std::string& why) { return why.empty() ? "" : fmt::format(" ({})", why); }

std::string arithmetic_of(const DeviceInfo& info, std::uint32_t lanes, bool optimise) {
  try {
    Device device(info);
    return probe_arithmetic(device, lanes, optimise).name();
  } catch (const Error& error) {
    return fmt::format("unknown: {}", error.what());
  }
}

ExitCode devices_command() {
  Execution execution;
  read_execution_environment(execution);
  const std::vector<DeviceInfo> devices = list_devices();
  if (devices.empty()) (void)select_devices("all");  // throws, with advice
  for (const DeviceInfo& info : devices) {
    fmt::print("{}: {}\n", info.index, info.name);
    fmt::print("   {} ({}), {}, driver {}\n", info.platform, info.vendor, info.version, info.driver);
    fmt::print(
        "   {}, {} compute units{}, {} memory{}, at most {} in one piece\n",
        info.gpu   ? "GPU"
        : info.cpu ? "CPU"
                   : "accelerator",
        info.whole() ? fmt::to_string(info.whole_units) : fmt::format("{} of {}", info.compute_units, info.whole_units),
        limit_of(info.units_limit), gibibytes(info.memory_bytes), limit_of(info.memory_limit),
        gibibytes(info.max_allocation_bytes));
    if (info.divisible && info.compute_units > 1)
      fmt::print("   can be divided: --devices {}:{}x1 for {} devices of one compute unit\n", info.index,
                 info.compute_units, info.compute_units);
    if (!info.whole() && !info.divisible)
      fmt::print("   makes no sub-devices: renders keep to fewer compute units, small launches may not\n");
    if (!info.unusable.empty()) {
      fmt::print("   cannot be used: {}\n", info.unusable);
      continue;
    }
    const WavefrontConfig config = configure(info, execution);
    fmt::print("   runs {} lanes, {}, layout {}, {} paths in flight\n", config.lanes,
               config.chunked ? "chunks" : "queues", config.layout, config.capacity());
    fmt::print("   divide and square root {}, denormals {}\n",
               info.own_division && config.lanes == 1 ? "by eikon's own code"
               : info.correctly_rounded_divide_sqrt   ? "correctly rounded"
                                                      : "not promised to be exact",
               info.denormals ? "kept" : "flushed");
    fmt::print("   arithmetic {}\n", arithmetic_of(info, config.lanes, execution.optimise));
  }
  std::vector<std::string> notes;
  (void)select_devices("all", 0, &notes);
  for (const std::string& note : notes) fmt::print("{}\n", note);
  const HostLimits host = host_limits();
  fmt::print("host: {} threads ({}), {} memory ({})\n", host.threads, host.threads_why, gibibytes(host.memory_bytes),
             host.memory_why);
  return ExitCode::done;
}

}  // namespace

void add_devices(CommandFlags& root, Command& chosen) {
  root.command("devices", "list every OpenCL device, and how eikon would use it", "Example:\n  eikon devices")
      .run(chosen, devices_command);
}

}  // namespace eikon
