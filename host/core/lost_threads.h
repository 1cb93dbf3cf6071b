// SPDX-License-Identifier: Apache-2.0
// Counts lost threads: they hang in a call of a driver, which cannot be cancelled, so nobody waits
// for them. A lost thread must own, or share, everything that it may still touch.
#pragma once

namespace eikon {

void thread_is_lost();
/// A lost thread has ended after all.
void lost_thread_ended();
[[nodiscard]] int lost_threads();
/// Returns `code` for main(). While threads are lost it flushes stdout and stderr and ends the
/// process at once instead, because destructors of a driver would wait for such a thread, or free
/// memory that it uses.
int leave_process(int code);
/// The same for a process whose main() is not eikon's, such as that of Python: from now on exit()
/// ends it at once while threads are lost, with the code that exit() has. To be called once a
/// thread is lost, because what is registered for exit() later comes first, and a driver registers
/// its destructors when it is loaded.
void leave_process_at_exit();

}  // namespace eikon
