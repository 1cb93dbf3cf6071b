// SPDX-License-Identifier: Apache-2.0
// Times of launches and transfers from the events that the queue records anyway; resolving them happens where the host
// waits for the device for other reasons, so that profiling adds no synchronisation [pbrt-v4, gpu/util.cpp].
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace eikon {

struct StageTotals {
  std::uint64_t launches = 0;
  std::uint64_t items = 0;
  std::uint64_t bytes = 0;  // of transfers
  double seconds = 0, seconds_min = 0, seconds_max = 0;
};

/// One finished launch or transfer, in seconds on the clock of host_seconds().
struct Span {
  std::string name;
  double begin_s = 0, end_s = 0;
};

class Profiler {
 public:
  /// A finished launch or transfer: seconds on the clock of host_seconds().
  void record(const std::string& name, double begin_s, double end_s, std::uint64_t items, std::uint64_t bytes);
  /// Adds items to a stage whose count became known only after its launch.
  void add_items(const std::string& name, std::uint64_t items) { totals_[name].items += items; }
  /// Books parts of what launches of `name` took since the last call on other stages: those that ran within them.
  /// shares  of that time, by stage; the rest stays with `name`
  void divide(const std::string& name, const std::map<std::string, double>& shares);
  /// Forgets all totals and spans so far: what opened the device is not part of the work.
  void restart();
  /// Keeps every span, for --profile; off by default (totals only).
  void keep_spans(bool keep) { keep_spans_ = keep; }
  [[nodiscard]] const std::map<std::string, StageTotals>& totals() const { return totals_; }
  [[nodiscard]] const std::vector<Span>& spans() const { return spans_; }
  /// Host seconds spent compiling: building programs, and first launches (where some drivers make the machine code).
  double compile_s = 0;

 private:
  bool keep_spans_ = false;
  std::map<std::string, StageTotals> totals_;
  std::map<std::string, double> undivided_s_;
  std::vector<Span> spans_;
};

/// Monotonic seconds since the process started measuring.
[[nodiscard]] double host_seconds();

}  // namespace eikon
