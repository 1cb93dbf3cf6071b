// SPDX-License-Identifier: Apache-2.0
#include "core/lost_threads.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <thread>

namespace eikon {
namespace {

std::atomic<int> lost{0};  // of the whole process

}  // namespace

void thread_is_lost() { ++lost; }
void lost_thread_ended() { --lost; }
int lost_threads() { return lost.load(); }

bool wait_for_lost_threads(double seconds) {
  using clock = std::chrono::steady_clock;
  const auto until = clock::now() + std::chrono::duration_cast<clock::duration>(std::chrono::duration<double>(seconds));
  while (lost.load() > 0 && clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return lost.load() == 0;
}

int leave_process(int code) {
  if (lost.load() == 0) return code;
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
}

}  // namespace eikon
