// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <limits>

#include "core/clock.h"

namespace eikon {

/// Spaces out work that holds others up, such as reading a film that devices add to, so that it
/// takes at most a share of the time. It expects that the next time takes as long as the last one.
/// Only one thread may use it.
class TimeShare {
 public:
  /// share         of the time, 0 < share <= 1
  /// least_rest_s  seconds between two times, however little they take
  explicit TimeShare(double share, double least_rest_s = 0) : share_(share), least_rest_s_(least_rest_s) {}

  /// True at first, and again once the rest after the last time is over.
  [[nodiscard]] bool is_due() const { return host_seconds() >= ended_s_ + std::max(least_rest_s_, took_s_ / share_); }
  /// Does the work now, due or not, and begins to rest when it has ended.
  template <class Work>
  void run(const Work& work) {
    const double begin_s = host_seconds();
    work();
    ended_s_ = host_seconds();
    took_s_ = ended_s_ - begin_s;
  }
  /// Begins to rest now, as if the work had just been done.
  void rest() { ended_s_ = host_seconds(); }
  /// The same, for work that is likely to take so many seconds.
  void rest(double expected_s) {
    rest();
    took_s_ = expected_s;
  }

 private:
  double share_, least_rest_s_;
  double ended_s_ = -std::numeric_limits<double>::infinity(), took_s_ = 0;
};

}  // namespace eikon
