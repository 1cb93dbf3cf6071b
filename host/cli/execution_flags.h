// SPDX-License-Identifier: Apache-2.0
// The flags that say how the work is done; they never change the image.
#pragma once
#include <string>

#include "cli/command_flags.h"
#include "pack/settings.h"

namespace eikon {

/// With this name, `bench rays --accel` measures every accelerator.
inline const char* const kEveryAccelerator = "all";

// These add flags; `execution` must outlive the parser.
/// Adds --instances.
void add_instance_flag(CommandFlags& flags, Execution& execution);
/// Adds --devices, --threads, --memory, --accel, --instances and --layout.
/// probe  --layout also takes kProbeLayouts
/// every  --accel also takes kEveryAccelerator
void add_execution_flags(CommandFlags& flags, Execution& execution, bool probe = false, bool every = false);

/// Lists the environment variables that eikon reads, for the end of --help.
[[nodiscard]] std::string environment_help();

}  // namespace eikon
