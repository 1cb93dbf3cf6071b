// SPDX-License-Identifier: Apache-2.0
// Adds up the times of launches and transfers from the events that a queue records where times are
// wanted (DeviceInfo::timed). They are read where the host waits for the device for other reasons,
// so that profiling adds no synchronisation [pbrt-v4, gpu/util.cpp].
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "core/trace.h"

namespace eikon {

/// The launches of one kernel, or the transfers of one kind, and the time that they took.
struct StageTotals {
  std::uint64_t launches = 0;
  std::uint64_t items = 0;   // that they worked on, such as paths; see Device::run()
  std::uint64_t bytes = 0;   // of transfers
  std::uint64_t pieces = 0;  // parts of other stages' launches in which it ran
  double seconds = 0;
  double seconds_min = 0, seconds_max = 0;  // shortest and longest launch or piece

  /// Adds a launch, or another duration.
  void add(double duration_s);
  void add_piece(double duration_s);
  /// Adds totals that were measured separately.
  StageTotals& operator+=(const StageTotals& more);
  [[nodiscard]] double seconds_mean() const;
};

/// The times of one device. One thread at a time may use it.
class Profiler {
 public:
  /// Counts a finished launch or transfer whose times are not known.
  void count(const std::string& name, std::uint64_t items, std::uint64_t bytes);
  /// Records a finished launch or transfer; times are host_seconds().
  void record(const std::string& name, double begin_s, double end_s, std::uint64_t items, std::uint64_t bytes);
  /// Records a transfer that other commands do not wait for.
  void record_beside(const std::string& name, double begin_s, double end_s, std::uint64_t bytes);
  /// Adds items to a stage when their number became known only after its launch.
  void add_items(const std::string& name, std::uint64_t items) { totals_[name].items += items; }
  /// Moves parts of the time of launches of `name` since the last call to the stages that ran
  /// within.
  /// shares: of that time, by stage; the rest stays with `name`
  void divide(const std::string& name, const std::map<std::string, double>& shares);
  /// Runs `work` and returns its times by stage; in the totals it is one launch of `name`. Commands
  /// before it must be finished, and its own commands must be when it returns.
  std::map<std::string, StageTotals> apart(const std::string& name, const std::function<void()>& work);
  /// Moves the totals so far to setup(), and begins new ones.
  void restart();
  /// Records every span in `trace` too, for --profile; null ends that.
  /// beside: the track of transfers that nothing waits for
  void follow(Trace* trace, Trace::Track track, Trace::Track beside) {
    trace_ = trace, track_ = track, beside_track_ = beside;
  }

  /// Totals since restart(), by the names of kernels and transfers.
  [[nodiscard]] const std::map<std::string, StageTotals>& totals() const { return totals_; }
  /// Totals of everything before restart().
  [[nodiscard]] const std::map<std::string, StageTotals>& setup() const { return setup_; }
  /// Times between two commands, in which the queue was empty or the device prepared the next one.
  [[nodiscard]] const StageTotals& gaps() const { return gaps_; }
  /// Host seconds for building programs and for first launches, in which some drivers compile.
  double compile_s = 0;

 private:
  std::map<std::string, StageTotals> totals_, setup_;
  std::map<std::string, double> undivided_s_;
  StageTotals gaps_;
  double last_end_s_ = -1;  // end of the last command; negative: there was none
  Trace* trace_ = nullptr;
  Trace::Track track_ = 0, beside_track_ = 0;
};

}  // namespace eikon
