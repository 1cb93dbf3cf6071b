// SPDX-License-Identifier: Apache-2.0
#include "render/crew.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "core/lost_threads.h"
#include "core/clock.h"

namespace eikon {
namespace {

constexpr double kLate = 20;        // times what is expected
constexpr double kUnknownUnit = 6;  // times the watchdog's seconds
constexpr double kAsk_s = 0.01;     // devices without a unit ask again so often: what others have may be late by then
constexpr unsigned kFailuresInARow = 3;  // then a device is dropped
constexpr unsigned kFailures = 10;       // with fewer than that many units between them:
constexpr unsigned kForgiven = 16;       // then it has had a bad moment, and all before is forgiven
constexpr unsigned kNoted = 32;          // failures of a device that events tell of; the report counts all
constexpr double kStopped_s = 1;   // without a look at the devices: the whole process was stopped, and they with it
constexpr double kLeftOut = 0.05;  // of the work: less is the end that comes for every device

std::chrono::duration<double> seconds_of(double seconds) { return std::chrono::duration<double>(seconds); }

}  // namespace

const char* name_of(DeviceEvent::Kind kind) {
  switch (kind) {
    case DeviceEvent::Kind::failed:
      return "failed";
    case DeviceEvent::Kind::dropped:
      return "dropped";
    case DeviceEvent::Kind::hung:
      return "hung";
    case DeviceEvent::Kind::late:
      return "late";
    case DeviceEvent::Kind::left_out:
      break;
  }
  return "left_out";
}

Crew::Crew(std::vector<DeviceReport> devices, FilmState begin, std::uint32_t block, double watchdog_s)
    : film_(std::move(begin)),
      watchdog_s_(watchdog_s),
      schedule_(devices.size(), block),
      posts_(devices.size()),
      reports_(std::move(devices)) {
  for (std::size_t i = 0; i < posts_.size(); ++i) {
    posts_[i].since_s = host_seconds();
    if (reports_[i].error.empty()) continue;
    posts_[i].phase = Phase::ended;
    schedule_.leave(i);
    note(i, DeviceEvent::Kind::dropped, reports_[i].error);
  }
}

void Crew::note(std::size_t device, DeviceEvent::Kind kind, const std::string& text) {
  events_.push_back({host_seconds(), device, kind, text});
}

void Crew::enter(std::size_t device, Phase phase) {
  posts_[device].phase = phase;
  posts_[device].since_s = host_seconds();
  news_ = true;
  changed_.notify_all();
}

// ---- device threads ---------------------------------------------------------------------------------------------------

void Crew::opened(std::size_t device, const UnitLimits& limits, const DeviceReport& found) {
  const std::lock_guard lock(mutex_);
  Post& post = posts_[device];
  if (post.lost) return;
  post.was_open = true;
  DeviceReport& report = reports_[device];
  report.config = found.config;
  report.arithmetic = found.arithmetic;
  report.device_bytes = found.device_bytes;
  report.open_s += found.open_s;
  report.upload_bytes += found.upload_bytes;
  report.compile_s += found.compile_s;
  report.upload_s += found.upload_s;
  schedule_.join(device, limits);
  enter(device, Phase::idle);
}

std::optional<Schedule::Dealt> Crew::deal(std::size_t device) {
  Post& post = posts_[device];
  if (ended_ || post.lost) return std::nullopt;
  const double now_s = host_seconds();
  std::optional<Schedule::Dealt> dealt = schedule_.next(device, now_s);
  if (!dealt) return std::nullopt;
  post.units.push_back(dealt->id);
  if (post.units.size() == 1) enter(device, Phase::working);
  if (post.stretch_begin_s < 0) {
    post.stretch_begin_s = now_s;
    post.busy_before_s = reports_[device].busy_s;
  }
  if (stretch_begin_s_ < 0) {
    stretch_begin_s_ = now_s;
    rendered_before_s_ = totals_.render_s;
  }
  return dealt;
}

std::optional<Schedule::Dealt> Crew::next_unit(std::size_t device) {
  const std::lock_guard lock(mutex_);
  return deal(device);
}

std::optional<Schedule::Dealt> Crew::wait_for_unit(std::size_t device) {
  std::unique_lock lock(mutex_);
  while (!ended_ && !posts_[device].lost) {
    if (std::optional<Schedule::Dealt> dealt = deal(device)) return dealt;
    if (posts_[device].phase != Phase::idle) enter(device, Phase::idle);
    const bool others_work = !schedule_.complete();
    const double begin_s = host_seconds();
    work_.wait_for(lock, seconds_of(kAsk_s));
    if (others_work) reports_[device].wait_s += host_seconds() - begin_s;
  }
  return std::nullopt;
}

void Crew::finished(std::size_t device, const Schedule::Dealt& dealt, const UnitResult& result) {
  std::string arithmetic;
  {
    const std::lock_guard lock(mutex_);
    Post& post = posts_[device];
    const double now_s = host_seconds();
    const bool counts = schedule_.finished(dealt.id, post.since_s, now_s);
    if (post.lost) return;
    std::erase(post.units, dealt.id);
    post.since_s = now_s;
    post.failures_in_a_row = 0;
    if (++post.successes >= kForgiven) post.failures = 0;
    if (!counts) return;
    arithmetic = reports_[device].arithmetic.name();
    ++adding_;
  }
  try {
    film_.add(dealt.unit, result.sums, arithmetic);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    --adding_;
    throw;
  }
  const std::lock_guard lock(mutex_);
  --adding_;
  const double now_s = host_seconds();
  if (totals_.samples == 0) totals_.first_sample_s = now_s;
  totals_.samples += dealt.unit.path_count();
  totals_.render_s = rendered_before_s_ + now_s - stretch_begin_s_;
  totals_.rays += result.rays;
  totals_.given_up += result.given_up;
  totals_.given_up_surfaces |= result.given_up_surfaces;
  totals_.nonfinite += result.nonfinite;
  totals_.saturated += result.saturated;
  for (const RejectedSample& sample : result.rejected)
    if (totals_.rejected.size() < EK_REPORT_COUNT) totals_.rejected.push_back(sample);
  DeviceReport& report = reports_[device];
  report.samples += dealt.unit.path_count();
  report.rays += result.rays;
  ++report.units;
  if (report.begin_s == 0) report.begin_s = posts_[device].stretch_begin_s;
  report.end_s = now_s;
  report.rate = schedule_.rate(device);
  report.busy_s = posts_[device].busy_before_s + now_s - posts_[device].stretch_begin_s;
  if (adding_ == 0 && schedule_.complete()) {
    news_ = true;
    changed_.notify_all();
    work_.notify_all();
  }
}

bool Crew::failed(std::size_t device, const std::string& why) {
  const std::lock_guard lock(mutex_);
  Post& post = posts_[device];
  if (post.lost) return false;
  const std::size_t units = post.units.size();
  reports_[device].failures += units;
  schedule_.leave(device);
  post.units.clear();
  post.successes = 0;
  post.why = why;
  // What cannot be opened may lack memory, once more with less; a compiler would only say the same again.
  const unsigned most = post.was_open ? kFailuresInARow : 2;
  const bool again = ++post.failures_in_a_row < most && ++post.failures < kFailures && !ended_ && !error_;
  if (again) {
    if (++post.noted <= kNoted)
      note(device, DeviceEvent::Kind::failed, why + "; it is tried again, with smaller units");
  } else {
    post.dropped = true;
    reports_[device].error = why;
    note(device, DeviceEvent::Kind::dropped,
         post.failures_in_a_row > 1
             ? fmt::format("{}; it was dropped after it had failed {} times in a row", why, post.failures_in_a_row)
             : why + "; it was dropped");
  }
  enter(device, Phase::closing);
  work_.notify_all();
  return again;
}

bool Crew::reopening(std::size_t device) {
  const std::lock_guard lock(mutex_);
  if (posts_[device].lost || ended_) return false;
  schedule_.leave(device);  // until it is open
  enter(device, Phase::opening);
  return true;
}

void Crew::broke(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  news_ = true;
  changed_.notify_all();
}

void Crew::closing(std::size_t device, const DeviceReport& totals) {
  const std::lock_guard lock(mutex_);
  Post& post = posts_[device];
  if (post.lost) return;
  DeviceReport& report = reports_[device];
  for (const auto& [name, stage] : totals.stages) report.stages[name] += stage;
  report.gaps += totals.gaps;
  add_bounces(report.bounces, totals.bounces);
  if (post.units.empty()) enter(device, Phase::closing);
}

void Crew::ended(std::size_t device) {
  const std::lock_guard lock(mutex_);
  schedule_.leave(device);
  if (posts_[device].lost) lost_thread_ended();
  enter(device, Phase::ended);
}

// ---- the thread that called render() ----------------------------------------------------------------------------------

void Crew::open(const std::vector<WorkUnit>& boxes) {
  const std::lock_guard lock(mutex_);
  for (Post& post : posts_) post.stretch_begin_s = -1;
  stretch_begin_s_ = -1;
  schedule_.open(boxes);
  work_.notify_all();
}

void Crew::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  for (std::size_t i = 0; i < posts_.size(); ++i)
    if (const double at = schedule_.left_out_at(i); at > kLeftOut)
      note(i, DeviceEvent::Kind::left_out,
           fmt::format("it was left out of the last {:.0f} % of the work: its units would have been late", 100 * at));
  work_.notify_all();
}

void Crew::wait(double seconds) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, seconds_of(seconds), [&] { return news_; });
  news_ = false;
}

bool Crew::counts(const Post& post) const {
  return std::any_of(post.units.begin(), post.units.end(), [&](std::uint64_t id) { return schedule_.counts(id); });
}

double Crew::limit_s(const Post& post) const {
  switch (post.phase) {
    case Phase::opening:
      return kOpening * watchdog_s_;
    case Phase::working:
      break;
    case Phase::closing:
      return watchdog_s_;
    default:
      return 1e30;
  }
  double expected_s = 0;
  for (const std::uint64_t id : post.units) {
    const std::optional<double> unit_s = schedule_.expected_s(id);
    if (!unit_s && schedule_.counts(id)) return kUnknownUnit * watchdog_s_;
    expected_s += unit_s.value_or(0);
  }
  return std::max(watchdog_s_, kLate * expected_s);
}

void Crew::give_up(std::size_t device, DeviceEvent::Kind kind, const std::string& text) {
  Post& post = posts_[device];
  schedule_.leave(device);
  reports_[device].failures += kind == DeviceEvent::Kind::hung ? post.units.size() : 0;
  post.units.clear();
  post.lost = true;
  if (kind == DeviceEvent::Kind::hung) reports_[device].error = text;
  thread_is_lost();
  if (!text.empty()) note(device, kind, text);
  work_.notify_all();
}

void Crew::watch() {
  const std::lock_guard lock(mutex_);
  const double now_s = host_seconds(), gap_s = watched_s_ < 0 ? 0 : now_s - watched_s_;
  watched_s_ = now_s;
  for (std::size_t i = 0; i < posts_.size(); ++i) {
    Post& post = posts_[i];
    if (post.lost || post.phase == Phase::ended) continue;
    if (std::exchange(post.excused_since_s, post.since_s) != post.since_s) post.excused_s = 0;
    if (gap_s > kStopped_s) post.excused_s += std::min(gap_s, now_s - post.since_s);
    const double seconds = now_s - post.since_s - post.excused_s;
    if (seconds <= limit_s(post)) continue;
    const char* const what = post.phase == Phase::opening   ? "opening it"
                             : post.phase == Phase::working ? "a unit of its work"
                                                            : "closing it";
    const bool after_failure = post.phase == Phase::closing && post.failures_in_a_row > 0;
    give_up(i, DeviceEvent::Kind::hung,
            fmt::format("{}{} did not end within {:.3g} s: it was given up", after_failure ? post.why + "; then " : "",
                        what, seconds));
  }
}

bool Crew::all_ended() const {
  // What is being added to the film comes to its end, also of a device that was given up for its next unit.
  return adding_ == 0 && std::all_of(posts_.begin(), posts_.end(),
                                     [](const Post& post) { return post.lost || post.phase == Phase::ended; });
}

void Crew::wait_for_threads() {
  constexpr double kPatience = 0.02;  // of the time it took to render
  constexpr double kLeast_s = 0.1;
  const double begin_s = host_seconds();
  while (true) {
    wait(0.01);
    watch();
    const std::lock_guard lock(mutex_);
    if (all_ended()) return;
    if (host_seconds() - begin_s < std::max(kLeast_s, kPatience * totals_.render_s)) continue;
    const bool complete = schedule_.complete();
    for (std::size_t i = 0; i < posts_.size(); ++i) {
      const Post& post = posts_[i];
      if (post.lost || post.dropped) continue;
      if (post.phase == Phase::opening)  // a compiler may take long, and nothing is lost with it
        give_up(i, DeviceEvent::Kind::late, complete ? "the others had done everything before it was ready" : "");
      if (post.phase == Phase::working && !counts(post))
        give_up(i, DeviceEvent::Kind::late, "it was so late with a unit that another device did it");
    }
  }
}

Crew::State Crew::state() {
  const std::lock_guard lock(mutex_);
  if (error_) return State::broken;
  if (adding_ == 0 && schedule_.complete()) return State::done;
  const bool manned = std::any_of(posts_.begin(), posts_.end(), [](const Post& post) {
    return !post.lost && !post.dropped && post.phase != Phase::ended;
  });
  return manned || adding_ > 0 ? State::working : State::unmanned;
}

bool Crew::is_opening() {
  const std::lock_guard lock(mutex_);
  return std::any_of(posts_.begin(), posts_.end(),
                     [](const Post& post) { return !post.lost && post.phase == Phase::opening; });
}

std::exception_ptr Crew::error() {
  const std::lock_guard lock(mutex_);
  return error_;
}

std::string Crew::last_words() {
  const std::lock_guard lock(mutex_);
  std::string text;
  for (std::size_t i = 0; i < posts_.size(); ++i) {
    if (posts_.size() == 1) return reports_[i].error;
    text += fmt::format("{}device {}: {}", text.empty() ? "" : "; ", reports_[i].info.selector, reports_[i].error);
  }
  return text;
}

Crew::Totals Crew::totals() {
  const std::lock_guard lock(mutex_);
  return totals_;
}

std::vector<DeviceReport> Crew::device_reports() {
  const std::lock_guard lock(mutex_);
  return reports_;
}

std::vector<DeviceEvent> Crew::events() {
  const std::lock_guard lock(mutex_);
  return events_;
}

bool Crew::is_lost(std::size_t device) {
  const std::lock_guard lock(mutex_);
  return posts_[device].lost;
}

}  // namespace eikon
