// SPDX-License-Identifier: Apache-2.0
// SIGINT, SIGTERM and SIGHUP end a render and keep what is done; SIGUSR1 asks for a checkpoint. One
// thread receives them, and all others block them: drivers that compile within the process (LLVM)
// replace signal handlers by their own, which lose some signals and handle others at the wrong
// moment.
#pragma once
#include <atomic>
#include <cstdint>

#include "core/error.h"

namespace eikon {

/// Starts the thread that receives signals. To be called once per process, before any other thread
/// begins. Until catch_stop_signals() is called, signals that stop do what they did before. SIGUSR1
/// ends nothing, even if there is no checkpoint to write. Writing to a pipe without a reader
/// becomes an error instead of a signal.
void receive_signals();

/// From now on, signals that stop set the flag that is returned. A SIGINT or SIGTERM that comes a
/// second or more after the first of the two ends the process at once; SIGHUP does not count, since
/// shells and terminals each send one.
[[nodiscard]] const std::atomic<bool>& catch_stop_signals();

/// The exit code after the signal that came: interrupted after SIGINT, else terminated.
[[nodiscard]] ExitCode stop_exit_code();

/// The number of SIGUSR1 signals so far.
[[nodiscard]] std::uint64_t checkpoint_signals();

}  // namespace eikon
