// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "pack/settings.h"

namespace eikon {

/// Reads the environment variables EIKON_LANES, EIKON_STAGES, EIKON_NO_OPTIMISE, EIKON_WATCHDOG and EIKON_TICKS, which
/// `eikon --help` explains, and holds the host's own threads to `execution.threads` and to what the process may use, as
/// long as `execution` or a copy of it lives.
/// throws UsageError
void read_execution_environment(Execution& execution);

}  // namespace eikon
