// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <thread>

#include "core/lost_threads.h"

namespace eikon::test {

/// Waits until no thread is lost, or for so long.
/// returns  true when no thread is lost
inline bool wait_for_lost_threads(double seconds) {
  using clock = std::chrono::steady_clock;
  const auto until = clock::now() + std::chrono::duration_cast<clock::duration>(std::chrono::duration<double>(seconds));
  while (lost_threads() > 0 && clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return lost_threads() == 0;
}

}  // namespace eikon::test
