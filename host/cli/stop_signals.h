// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM end the work in hand and keep what is done; a second one ends the process.
#pragma once
#include <atomic>

#include "core/error.h"

namespace eikon {

/// From now on the signals set a flag, which is returned. Once per process.
const std::atomic<bool>& catch_stop_signals();

/// What the process returns after the signal that came: terminated after SIGTERM, else interrupted.
[[nodiscard]] ExitCode stop_exit_code();

}  // namespace eikon
