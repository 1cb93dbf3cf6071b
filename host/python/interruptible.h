// SPDX-License-Identifier: Apache-2.0
// Work that Python can interrupt.
#pragma once
#include <atomic>
#include <functional>

namespace eikon::python {

/// Throws DeviceError if the process is a copy of one that had called this: threads, locks and
/// devices of drivers are not in it.
void require_own_process();

/// Runs `work` with Python's lock released, and returns when it has ended: on a thread of its own
/// if it is called on Python's main thread, else on the calling thread. On the main thread, a
/// signal that Python has a handler for sets the flag that `work` gets. An exception that the
/// handler raises is thrown once `work` has ended; without one, whatever `work` throws is. Drivers
/// that compile within the process (LLVM) replace signal handlers by their own. Those of Python are
/// put back at the end; and meanwhile the main thread receives SIGINT here, before those see it.
void run_interruptible(const std::function<void(std::atomic<bool>& stop)>& work);

}  // namespace eikon::python
