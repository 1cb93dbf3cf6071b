// SPDX-License-Identifier: Apache-2.0
// After a device has failed its units are smaller, and larger ones are tried again later. Plain
// numbers, no device.
#pragma once
#include <algorithm>
#include <cstdint>

namespace eikon {

/// Units are never made smaller than this: smaller ones are slow, and the state of so few paths
/// takes less than a megabyte.
inline constexpr std::uint32_t kMinUnitPaths = 1U << 10;

/// The most paths of a unit after it was made smaller so many times: a quarter for each of them.
/// paths  most paths of a unit that was not made smaller
[[nodiscard]] inline std::uint32_t shrunk_unit(std::uint32_t paths, unsigned times) {
  return std::max(paths >> std::min(2 * times, 31U), std::min(paths, kMinUnitPaths));
}

/// A device may fail once by chance, because units are too large for it, or because it lacks memory
/// that it has later. So larger units are tried again after some units have succeeded, and after
/// twice as many whenever that fails soon.
class UnitShrink {
 public:
  /// How many times units were made smaller and not larger again, for shrunk_unit().
  [[nodiscard]] unsigned times() const { return times_; }
  /// The device was opened for units of this size. Times are seconds of any one clock.
  void opened(double begin_s, double end_s) {
    open_s_ = end_s - begin_s, since_s_ = end_s;
    units_ = 0;
  }
  /// A unit succeeded.
  void finished() { ++units_; }
  /// True if the device should be opened again for larger units.
  [[nodiscard]] bool wants_larger_units(double now_s) const {
    return times_ > 0 && units_ >= wait_ && now_s - since_s_ >= kPays * open_s_;
  }
  /// The device is closed in order to be opened for larger units.
  void enlarge() {
    --times_;
    units_ = 0;
    enlarged_ = true;
  }
  /// The device failed, while it was open or when it was to be opened.
  void failed() {
    const bool soon = units_ < wait_;  // after many units their size is not likely to be the cause
    wait_ = enlarged_ && soon ? std::min(2 * wait_, kMaxWait) : kFirstWait;
    if (soon || times_ == 0) ++times_;
    units_ = 0;
    enlarged_ = false;
  }

 private:
  static constexpr std::uint64_t kFirstWait = 8, kMaxWait = std::uint64_t{1} << 32;  // units
  static constexpr double kPays = 20;  // wait this many times as long as opening takes, which then costs 5 % at most
  unsigned times_ = 0;
  bool enlarged_ = false;                        // the last change made units larger
  std::uint64_t units_ = 0, wait_ = kFirstWait;  // since it was opened
  double open_s_ = 0, since_s_ = 0;
};

}  // namespace eikon
