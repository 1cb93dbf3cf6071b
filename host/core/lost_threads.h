// SPDX-License-Identifier: Apache-2.0
// Threads that nobody waits for: they are in a call of a driver that does not return, which cannot be cancelled. Whatever such a
// thread may still touch must be its own, or shared with it.
#pragma once

namespace eikon {

void thread_is_lost();
/// A lost one has ended after all.
void lost_thread_ended();
[[nodiscard]] int lost_threads();
/// Waits until none is lost, for so long at most. returns whether that is so
bool wait_for_lost_threads(double seconds);

/// What main() returns. While threads are lost it does not return, but ends the process there and then, with what was written to
/// stdout and stderr: destructors of a driver would wait for such a thread, or take from under it what it uses.
int leave_process(int code);

}  // namespace eikon
