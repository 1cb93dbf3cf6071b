// SPDX-License-Identifier: Apache-2.0
// Work that Python can interrupt.
#pragma once
#include <atomic>
#include <functional>

namespace eikon::python {

/// Runs `work` on a thread of its own, with Python's lock released, and returns when it has ended. On the main thread, a signal
/// that Python has a handler for sets the flag that `work` gets. What the handler raises is thrown once `work` has ended; else
/// what `work` throws.
/// Drivers that compile within the process (LLVM) replace signal handlers by their own. They are put back at the end; and
/// meanwhile SIGINT is received here, before those see it.
void run_interruptible(const std::function<void(std::atomic<bool>& stop)>& work);

}  // namespace eikon::python
