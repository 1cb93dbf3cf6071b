// SPDX-License-Identifier: Apache-2.0
// Times of launches and transfers from the events that the queue records anyway; resolving them happens where the host
// waits for the device for other reasons, so that profiling adds no synchronisation [pbrt-v4, gpu/util.cpp].
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "core/clock.h"
#include "core/trace.h"

namespace eikon {

struct StageTotals {
  std::uint64_t launches = 0;
  std::uint64_t items = 0;
  std::uint64_t bytes = 0;   // of transfers
  std::uint64_t pieces = 0;  // of other stages' launches that it ran within
  double seconds = 0;
  double seconds_min = 0, seconds_max = 0;  // of a launch or piece

  /// Adds a launch, or another stretch of time.
  void add(double duration_s);
  void add_piece(double duration_s);
  /// Adds what was measured apart from it.
  StageTotals& operator+=(const StageTotals& more);
  [[nodiscard]] double seconds_mean() const;
};

class Profiler {
 public:
  /// A finished launch or transfer: seconds on the clock of host_seconds().
  void record(const std::string& name, double begin_s, double end_s, std::uint64_t items, std::uint64_t bytes);
  /// The same of a transfer that other commands do not wait for.
  void record_beside(const std::string& name, double begin_s, double end_s, std::uint64_t bytes);
  /// Adds items to a stage whose count became known only after its launch.
  void add_items(const std::string& name, std::uint64_t items) { totals_[name].items += items; }
  /// Books parts of what launches of `name` took since the last call on other stages: those that ran within them.
  /// shares  of that time, by stage; the rest stays with `name`
  void divide(const std::string& name, const std::map<std::string, double>& shares);
  /// What `work` takes, by stage; in the totals it is one launch of `name`. Commands before it must be finished, and its own when it
  /// returns.
  std::map<std::string, StageTotals> apart(const std::string& name, const std::function<void()>& work);
  /// What came so far opened the device; totals begin anew.
  void restart();
  /// Also tells `trace` every span, for --profile; null: no more. beside: the track of transfers that nothing waits for
  void follow(Trace* trace, Trace::Track track, Trace::Track beside) {
    trace_ = trace, track_ = track, beside_track_ = beside;
  }

  [[nodiscard]] const std::map<std::string, StageTotals>& totals() const { return totals_; }
  /// The same of what came before restart().
  [[nodiscard]] const std::map<std::string, StageTotals>& setup() const { return setup_; }
  /// The times between a command and the next, in which the queue was empty or the device getting ready.
  [[nodiscard]] const StageTotals& gaps() const { return gaps_; }
  /// Host seconds spent compiling: building programs, and first launches (where some drivers make the machine code).
  double compile_s = 0;

 private:
  std::map<std::string, StageTotals> totals_, setup_;
  std::map<std::string, double> undivided_s_;
  StageTotals gaps_;
  double last_end_s_ = -1;  // of the last command; negative: there was none
  Trace* trace_ = nullptr;
  Trace::Track track_ = 0, beside_track_ = 0;
};

}  // namespace eikon
