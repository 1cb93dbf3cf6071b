// SPDX-License-Identifier: Apache-2.0
#include "core/lost_threads.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <mutex>

namespace eikon {
namespace {

std::atomic<int> lost{0};  // of the whole process

}  // namespace

void thread_is_lost() { ++lost; }
void lost_thread_ended() { --lost; }
int lost_threads() { return lost.load(); }

int leave_process(int code) {
  if (lost.load() == 0) return code;
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
}

void leave_process_at_exit() {
  static std::once_flag once;
  std::call_once(once, [] { (void)on_exit([](int code, void*) { (void)leave_process(code); }, nullptr); });
}

}  // namespace eikon
