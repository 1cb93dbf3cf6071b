// SPDX-License-Identifier: Apache-2.0
#include "device/profiler.h"

#include <algorithm>
#include <utility>

namespace eikon {

void StageTotals::add(double duration_s) {
  add_piece(duration_s);
  --pieces, ++launches;
}

void StageTotals::add_piece(double duration_s) {
  seconds_min = launches + pieces == 0 ? duration_s : std::min(seconds_min, duration_s);
  seconds_max = std::max(seconds_max, duration_s);
  seconds += duration_s;
  ++pieces;
}

StageTotals& StageTotals::operator+=(const StageTotals& more) {
  if (more.launches + more.pieces > 0) {
    seconds_min = launches + pieces == 0 ? more.seconds_min : std::min(seconds_min, more.seconds_min);
    seconds_max = std::max(seconds_max, more.seconds_max);
  }
  launches += more.launches;
  items += more.items;
  bytes += more.bytes;
  pieces += more.pieces;
  seconds += more.seconds;
  return *this;
}

double StageTotals::seconds_mean() const { return launches + pieces > 0 ? seconds / double(launches + pieces) : 0; }

void Profiler::count(const std::string& name, std::uint64_t items, std::uint64_t bytes) {
  StageTotals& stage = totals_[name];
  ++stage.launches;
  stage.items += items;
  stage.bytes += bytes;
}

void Profiler::record(const std::string& name, double begin_s, double end_s, std::uint64_t items, std::uint64_t bytes) {
  StageTotals& stage = totals_[name];
  stage.add(end_s - begin_s);
  stage.items += items;
  stage.bytes += bytes;
  undivided_s_[name] += end_s - begin_s;
  if (last_end_s_ >= 0) gaps_.add(std::max(0.0, begin_s - last_end_s_));
  last_end_s_ = end_s;
  if (trace_ != nullptr) trace_->span(track_, name, begin_s, end_s);
}

void Profiler::record_beside(const std::string& name, double begin_s, double end_s, std::uint64_t bytes) {
  StageTotals& stage = totals_[name];
  stage.add(end_s - begin_s);
  stage.bytes += bytes;
  if (trace_ != nullptr) trace_->span(beside_track_, name, begin_s, end_s);
}

void Profiler::divide(const std::string& name, const std::map<std::string, double>& shares) {
  const double whole = std::exchange(undivided_s_[name], 0.0);
  for (const auto& [stage_name, share] : shares) {
    totals_[stage_name].add_piece(whole * share);
    totals_[name].seconds -= whole * share;
  }
}

std::map<std::string, StageTotals> Profiler::apart(const std::string& name, const std::function<void()>& work) {
  std::map<std::string, StageTotals> before = std::exchange(totals_, {});
  const std::map<std::string, double> undivided_before = undivided_s_;
  work();
  undivided_s_ = undivided_before;
  std::map<std::string, StageTotals> taken = std::exchange(totals_, std::move(before));
  double seconds = 0;
  for (const auto& [stage, totals] : taken) seconds += totals.seconds;
  totals_[name].add(seconds);
  return taken;
}

void Profiler::restart() {
  setup_ = std::exchange(totals_, {});
  undivided_s_.clear();
  gaps_ = {};
  last_end_s_ = -1;
}

}  // namespace eikon
