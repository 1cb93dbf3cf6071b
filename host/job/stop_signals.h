// SPDX-License-Identifier: Apache-2.0
// SIGINT, SIGTERM and SIGHUP end the work in hand and keep what is done; SIGUSR1 asks for a checkpoint. A thread of its own takes
// them, and all others block them: drivers that compile within the process (LLVM) put handlers of their own in the place of any,
// which lose some signals and run in the wrong moment for others.
#pragma once
#include <atomic>
#include <cstdint>

#include "core/error.h"

namespace eikon {

/// To be called before any other thread begins; once per process. Until catch_stop_signals() asks for them, those that stop do what they
/// did before; SIGUSR1 ends nothing, also where there is no checkpoint to write. From now on what is written to a pipe that nobody reads any more is an error like any other.
void receive_signals();

/// From now on signals that stop set a flag, which is returned. A second SIGINT or SIGTERM ends the process at once; a second
/// SIGHUP does not: shells and terminals both send one.
[[nodiscard]] const std::atomic<bool>& catch_stop_signals();

/// What the process returns after the signal that came: interrupted after SIGINT, else terminated.
[[nodiscard]] ExitCode stop_exit_code();

/// How often SIGUSR1 has come.
[[nodiscard]] std::uint64_t checkpoint_signals();

}  // namespace eikon
