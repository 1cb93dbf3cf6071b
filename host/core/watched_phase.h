// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <utility>

namespace eikon {

/// The seconds of a phase of another thread's work, as a thread sees them that looks often. A long pause between two
/// looks means that the whole process was stopped, and does not count.
class WatchedPhase {
 public:
  /// since_s: begin of the phase; gap_s: since the look before this one
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
