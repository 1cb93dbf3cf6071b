// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>

#include "render/settings.h"

namespace eikon {

/// --devices, --accel, --layout, and what is for development; they never change the image. `execution` must outlive the parser.
inline void add_execution_options(CLI::App& command, Execution& execution) {
  command.add_option("--devices", execution.devices, "all, or a list of indices, cpu, gpu, parts of names; see `eikon devices`")
      ->capture_default_str();
  command.add_option("--accel", execution.accel, "bvh, or none: every ray against every triangle")
      ->check(CLI::IsMember({"bvh", "none"}))->capture_default_str();
  command.add_option("--layout", execution.layout, "of the tree: bvh8 (CPU devices) or bvh2 (GPU devices); by device if not given")
      ->check(CLI::IsMember({"bvh8", "bvh2"}));
}

}  // namespace eikon
