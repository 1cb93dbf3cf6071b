// SPDX-License-Identifier: Apache-2.0
#include "instruments/selftest.h"

#include <fmt/format.h>

#include <memory>

#include "cli/commands.h"
#include "job/log.h"

namespace eikon {
namespace {

ExitCode selftest_command(const std::string& devices) {
  Execution execution;
  read_execution_environment(execution);
  bool passed = true;
  for (const DeviceInfo& info : select_devices(devices)) {
    fmt::print("device {} {}\n", info.index, info.name);
    for (const Check& check : selftest(info, execution)) {
      fmt::print("  {:<22} {:<4}  {}\n", check.name, check.passed ? "ok" : "FAIL", check.detail);
      passed = passed && check.passed;
    }
  }
  if (passed) return ExitCode::done;
  print_to_stderr(
      "eikon: selftest failed: images from this device are not to be trusted; update its driver or leave it out "
      "with --devices\n");
  return ExitCode::device;
}

}  // namespace

void add_selftest(CommandFlags& root, Command& chosen) {
  auto devices = std::make_shared<std::string>("all");
  CommandFlags flags = root.command("selftest", "check every device by probes and by scenes with known answers",
                                    "Example:\n  eikon selftest");
  flags.group("Devices");
  flags.text({"--devices", "LIST", "as in `eikon render` [all]"}, *devices);
  flags.run(chosen, [devices] { return selftest_command(*devices); });
}

}  // namespace eikon
