// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "pack/settings.h"

namespace eikon {

/// Reads EIKON_LANES, EIKON_STAGES, EIKON_NO_OPTIMISE, EIKON_WATCHDOG and EIKON_TICKS, which
/// `eikon --help` explains. As long as `execution` or a copy of it lives, the host uses at most
/// `execution.threads` threads, and at most those that the process may use.
/// throws UsageError
void read_execution_environment(Execution& execution);

}  // namespace eikon
