// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <utility>

namespace eikon {

/// Measures how long a phase of another thread's work has taken, for a watchdog that asks often. A
/// long pause between two of its questions means that the whole process was stopped (as by
/// SIGSTOP), and that time does not count.
class WatchedPhase {
 public:
  /// Returns the seconds of the phase so far, without those in which the process was stopped.
  /// since_s, now_s  begin of the phase, and now, on one clock
  /// gap_s           seconds since the watchdog asked last
  [[nodiscard]] double seconds(double since_s, double now_s, double gap_s) {
    constexpr double kStoppedProcess_s = 1;
    if (std::exchange(since_s_, since_s) != since_s) excused_s_ = 0;
    if (gap_s > kStoppedProcess_s) excused_s_ += std::min(gap_s, now_s - since_s);
    return now_s - since_s - excused_s_;
  }

 private:
  double since_s_ = 0, excused_s_ = 0;
};

}  // namespace eikon
