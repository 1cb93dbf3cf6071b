// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/execution_options.h"
#include "device/device.h"
#include "render/arithmetic.h"
#include "render/wavefront.h"

namespace eikon {
namespace {

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
    fmt::print("   {}, {} compute units, {:.1f} GiB memory, at most {:.1f} GiB in one piece\n",
               info.gpu   ? "GPU"
               : info.cpu ? "CPU"
                          : "accelerator",
               info.compute_units, double(info.memory_bytes) / (1U << 30),
               double(info.max_allocation_bytes) / (1U << 30));
    if (!info.unusable.empty()) {
      fmt::print("   cannot be used: {}\n", info.unusable);
      continue;
    }
    const WavefrontConfig config = configure(info, execution);
    fmt::print("   runs {} lanes, {}, layout {}, {} paths in flight\n", config.lanes,
               config.chunked ? "chunks" : "queues", config.layout, config.capacity());
    fmt::print("   divide and square root {}, denormals {}\n",
               info.correctly_rounded_divide_sqrt ? "correctly rounded" : "not promised to be exact",
               info.denormals ? "kept" : "flushed");
    fmt::print("   arithmetic {}\n", arithmetic_of(info, config.lanes, execution.optimise));
  }
  return ExitCode::done;
}

}  // namespace

void add_devices(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("devices", "every OpenCL device, and what eikon makes of it");
  command->footer("Example:\n  eikon devices");
  command->callback([&chosen] { chosen = devices_command; });
}

}  // namespace eikon
