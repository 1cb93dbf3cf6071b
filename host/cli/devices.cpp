// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "cli/commands.h"
#include "device/device.h"
#include "render/wavefront.h"

namespace eikon {
namespace {

ExitCode devices_command() {
  // Throws with advice when there is none.
  (void)select_devices("all");
  for (const DeviceInfo& info : list_devices()) {
    fmt::print("{}: {}\n", info.index, info.name);
    fmt::print("   {} ({}), {}, driver {}\n", info.platform, info.vendor, info.version, info.driver);
    fmt::print("   {}, {} compute units, {:.1f} GiB memory, at most {:.1f} GiB in one piece\n", info.gpu ? "GPU" : info.cpu ? "CPU" : "accelerator",
               info.compute_units, double(info.memory_bytes) / (1U << 30), double(info.max_allocation_bytes) / (1U << 30));
    if (!info.unusable.empty()) {
      fmt::print("   cannot be used: {}\n", info.unusable);
      continue;
    }
    const WavefrontConfig config = configure(info, Execution{});
    fmt::print("   runs {} lanes, {}, layout {}, {} paths in flight\n", config.lanes, config.chunked ? "chunks" : "queues", config.layout,
               config.capacity());
    fmt::print("   divide and square root {}, denormals {}\n", info.correctly_rounded_divide_sqrt ? "correctly rounded" : "not promised to be exact",
               info.denormals ? "kept" : "flushed");
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
