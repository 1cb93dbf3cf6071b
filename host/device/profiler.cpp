// SPDX-License-Identifier: Apache-2.0
#include "device/profiler.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace eikon {

double host_seconds() {
  using clock = std::chrono::steady_clock;
  static const clock::time_point start = clock::now();
  return std::chrono::duration<double>(clock::now() - start).count();
}

void Profiler::record(const std::string& name, double begin_s, double end_s, std::uint64_t items, std::uint64_t bytes) {
  StageTotals& stage = totals_[name];
  const double seconds = end_s - begin_s;
  stage.seconds_min = stage.launches == 0 ? seconds : std::min(stage.seconds_min, seconds);
  stage.seconds_max = std::max(stage.seconds_max, seconds);
  stage.seconds += seconds;
  stage.items += items;
  stage.bytes += bytes;
  ++stage.launches;
  undivided_s_[name] += seconds;
  if (keep_spans_) spans_.push_back({name, begin_s, end_s});
}

void Profiler::divide(const std::string& name, const std::map<std::string, double>& shares) {
  const double whole = std::exchange(undivided_s_[name], 0.0);
  for (const auto& [stage_name, share] : shares) {
    StageTotals& stage = totals_[stage_name];
    const double seconds = whole * share;
    stage.seconds_min = stage.seconds_max == 0 ? seconds : std::min(stage.seconds_min, seconds);
    stage.seconds_max = std::max(stage.seconds_max, seconds);
    stage.seconds += seconds;
    totals_[name].seconds -= seconds;
  }
}

void Profiler::restart() {
  undivided_s_.clear();
  totals_.clear();
  spans_.clear();
}

}  // namespace eikon
