// SPDX-License-Identifier: Apache-2.0
// How much smaller units are than a device could take, since it failed, and when larger ones are tried again. Plain numbers.
#pragma once
#include <algorithm>
#include <cstdint>

namespace eikon {

/// A device may fail for once, or because units are too large for it, or for want of memory that it has later. So larger units are
/// tried again after some that went well, and after twice as many whenever that fails soon.
class UnitShrink {
 public:
  /// Units are to be a quarter as large for each.
  [[nodiscard]] unsigned times() const { return times_; }
  /// It is open for units of that size. Seconds on any one clock.
  void opened(double begin_s, double end_s) {
    open_s_ = end_s - begin_s, since_s_ = end_s;
    units_ = 0;
  }
  /// A unit went well.
  void finished() { ++units_; }
  /// Whether to open it again for larger units.
  [[nodiscard]] bool is_over(double now_s) const {
    return times_ > 0 && units_ >= wait_ && now_s - since_s_ >= kPays * open_s_;
  }
  /// It is closed, for that.
  void grow() {
    --times_;
    units_ = 0;
    grown_ = true;
  }
  /// It failed, while it was open or when it was to be opened.
  void failed() {
    const bool soon = units_ < wait_;  // else their size does not seem to be what is wrong
    wait_ = grown_ && soon ? std::min(2 * wait_, kMostWait) : kFirstWait;
    if (soon || times_ == 0) ++times_;
    units_ = 0;
    grown_ = false;
  }

 private:
  static constexpr std::uint64_t kFirstWait = 8, kMostWait = std::uint64_t{1} << 32;  // units
  static constexpr double kPays = 20;  // times what opening it takes: it costs 5 % of the time at most
  unsigned times_ = 0;
  bool grown_ = false;                           // to the size that it has, rather than shrunk
  std::uint64_t units_ = 0, wait_ = kFirstWait;  // since it was opened
  double open_s_ = 0, since_s_ = 0;
};

}  // namespace eikon
