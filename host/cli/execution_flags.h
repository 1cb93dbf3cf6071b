// SPDX-License-Identifier: Apache-2.0
// The flags that say how the work is done; they never change the image.
#pragma once
#include <string>

#include "cli/command_flags.h"
#include "pack/settings.h"

namespace eikon {

/// `--accel` takes it beside the names of accelerators in `bench rays`: a table of all.
inline const char* const kEveryAccelerator = "all";

// `execution` must outlive the parser.
/// --instances.
void add_instance_flag(CommandFlags& flags, Execution& execution);
/// --devices, --threads, --memory, --accel, --instances, --layout.
/// probe: whether --layout takes kProbeLayouts; every: whether --accel takes kEveryAccelerator
void add_execution_flags(CommandFlags& flags, Execution& execution, bool probe = false, bool every = false);

/// The environment variables that eikon reads, for the end of --help.
[[nodiscard]] std::string environment_help();

}  // namespace eikon
