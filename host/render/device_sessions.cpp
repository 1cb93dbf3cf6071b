// SPDX-License-Identifier: Apache-2.0
#include "render/device_sessions.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "core/clock.h"
#include "core/lost_threads.h"

namespace eikon {
namespace {

// The watchdog abandons a device that takes longer than these limits.
constexpr double kLateFactor = 20;           // times the expected duration of its units
constexpr double kUnknownUnitWatchdogs = 6;  // times the watchdog's seconds, with its rate unknown
// At the end, threads whose units do not count get this share of the rendering time to come back.
constexpr double kPatienceShare = 0.02, kMinPatience_s = 0.1;
// A device that fails is opened again, up to these limits.
constexpr unsigned kMaxFailuresInARow = 3;
constexpr unsigned kMaxFailures = 10;        // with fewer than kForgivingUnits good units since each
constexpr unsigned kForgivingUnits = 16;     // so many good units clear the count of failures
constexpr unsigned kMaxFailureEvents = 32;   // of one device; its report counts all
// A device without a unit asks again so often, because units of other devices may be late by then.
constexpr double kAskInterval_s = 0.01;
// A smaller share of the work is not reported: every device runs out of work at the end.
constexpr double kReportedLeftOutShare = 0.05;

std::chrono::duration<double> seconds_of(double seconds) { return std::chrono::duration<double>(seconds); }

}  // namespace

DeviceSessions::DeviceSessions(std::vector<DeviceReport> devices, FilmState begin, std::uint32_t block,
                               double watchdog_s)
    : film_(std::move(begin)),
      watchdog_s_(watchdog_s),
      schedule_(devices.size(), block),
      sessions_(devices.size()),
      reports_(std::move(devices)) {
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    sessions_[i].since_s = host_seconds();
    if (reports_[i].error.empty()) continue;
    sessions_[i].phase = Phase::ended;
    schedule_.leave(i);
    note(i, DeviceEvent::Kind::dropped, reports_[i].error);
  }
}

void DeviceSessions::note(std::size_t device, DeviceEvent::Kind kind, const std::string& text) {
  events_.push_back({host_seconds(), device, kind, text});
}

void DeviceSessions::enter(std::size_t device, Phase phase) {
  sessions_[device].phase = phase;
  sessions_[device].since_s = host_seconds();
  tell();
}

void DeviceSessions::tell() {
  news_ = true;
  changed_.notify_all();
}

// ---- device threads

void DeviceSessions::opened(std::size_t device, const UnitLimits& limits, const DeviceReport& found) {
  const std::lock_guard lock(mutex_);
  Session& session = sessions_[device];
  if (session.lost) return;
  session.was_open = true;
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

std::optional<Schedule::Assignment> DeviceSessions::assign(std::size_t device) {
  Session& session = sessions_[device];
  if (ended_ || session.lost) return std::nullopt;
  const double now_s = host_seconds();
  std::optional<Schedule::Assignment> assignment = schedule_.next(device, now_s);
  if (!assignment) return std::nullopt;
  session.units.push_back(assignment->id);
  if (session.units.size() == 1) enter(device, Phase::working);
  if (session.range_begin_s < 0) {
    session.range_begin_s = now_s;
    session.busy_before_s = reports_[device].busy_s;
  }
  if (range_begin_s_ < 0) {
    range_begin_s_ = now_s;
    rendered_before_s_ = totals_.render_s;
  }
  return assignment;
}

std::optional<Schedule::Assignment> DeviceSessions::next_unit(std::size_t device) {
  const std::lock_guard lock(mutex_);
  return assign(device);
}

std::optional<Schedule::Assignment> DeviceSessions::wait_for_unit(std::size_t device) {
  std::unique_lock lock(mutex_);
  while (!ended_ && !sessions_[device].lost) {
    if (std::optional<Schedule::Assignment> assignment = assign(device)) return assignment;
    if (sessions_[device].phase != Phase::idle) enter(device, Phase::idle);
    const bool others_work = !schedule_.complete();
    const double begin_s = host_seconds();
    work_.wait_for(lock, seconds_of(kAskInterval_s));
    if (others_work) reports_[device].wait_s += host_seconds() - begin_s;
  }
  return std::nullopt;
}

void DeviceSessions::finished(std::size_t device, const Schedule::Assignment& assignment, const UnitResult& result) {
  std::string arithmetic;
  {
    const std::lock_guard lock(mutex_);
    Session& session = sessions_[device];
    const double now_s = host_seconds();
    const bool counts = schedule_.finished(assignment.id, session.since_s, now_s);
    if (session.lost) return;
    std::erase(session.units, assignment.id);
    session.since_s = now_s;
    session.failures_in_a_row = 0;
    if (++session.successes >= kForgivingUnits) session.failures = 0;
    if (!counts) {
      // Another device had finished it first: its samples count there, and its time counts here.
      reports_[device].repeated_rays += result.rays;
      count_time(device, now_s);
      return;
    }
    arithmetic = reports_[device].arithmetic.name();
    ++adding_;
  }
  try {
    film_.add(assignment.unit, result.sums, arithmetic);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    --adding_;
    if (!error_) error_ = std::current_exception();  // at once, since all that was opened may be finished
    throw;
  }
  const std::lock_guard lock(mutex_);
  --adding_;
  count_unit(device, assignment.unit, result);
  if (adding_ == 0 && schedule_.complete()) {
    tell();
    work_.notify_all();
  }
}

/// Adds a unit that is in the film to the totals of the render and of its device.
void DeviceSessions::count_unit(std::size_t device, const WorkUnit& unit, const UnitResult& result) {
  const double now_s = host_seconds();
  if (totals_.samples == 0) totals_.first_sample_s = now_s;
  totals_.samples += unit.path_count();
  totals_.render_s = rendered_before_s_ + now_s - range_begin_s_;
  totals_.rays += result.rays;
  totals_.search_failures += result.search_failures;
  totals_.search_failure_surfaces |= result.search_failure_surfaces;
  totals_.nonfinite += result.nonfinite;
  totals_.saturated += result.saturated;
  for (const PixelSample& sample : result.rejected)
    if (totals_.rejected.size() < EK_REPORT_COUNT) totals_.rejected.push_back(sample);
  DeviceReport& report = reports_[device];
  report.samples += unit.path_count();
  report.rays += result.rays;
  ++report.units;
  report.rate = schedule_.rate(device);
  count_time(device, now_s);
}

/// Adds the time of a device until now, when it has finished a unit.
void DeviceSessions::count_time(std::size_t device, double now_s) {
  DeviceReport& report = reports_[device];
  const Session& session = sessions_[device];
  if (session.range_begin_s < 0) return;  // the unit is of a round that is over
  if (report.begin_s == 0) report.begin_s = session.range_begin_s;
  report.end_s = now_s;
  report.busy_s = session.busy_before_s + now_s - session.range_begin_s;
}

bool DeviceSessions::failed(std::size_t device, const std::string& why, bool lasts) {
  const std::lock_guard lock(mutex_);
  Session& session = sessions_[device];
  if (session.lost) return false;
  reports_[device].failures += session.units.size();
  schedule_.leave(device);
  session.units.clear();
  session.successes = 0;
  session.why = why;
  // Opening may have failed for want of memory, so it gets one more try with smaller units.
  const unsigned most = lasts ? 1 : session.was_open ? kMaxFailuresInARow : 2;
  const bool again = ++session.failures_in_a_row < most && ++session.failures < kMaxFailures && !ended_ && !error_;
  if (again) {
    if (++session.noted <= kMaxFailureEvents)
      note(device, DeviceEvent::Kind::failed, why + "; it is tried again, with smaller units");
  } else {
    session.dropped = true;
    reports_[device].error = why;
    note(device, DeviceEvent::Kind::dropped,
         session.failures_in_a_row > 1
             ? fmt::format("{}; it was dropped after it had failed {} times in a row", why, session.failures_in_a_row)
             : why + "; it was dropped");
  }
  enter(device, Phase::closing);
  work_.notify_all();
  return again;
}

bool DeviceSessions::reopening(std::size_t device) {
  const std::lock_guard lock(mutex_);
  if (sessions_[device].lost || ended_) return false;
  schedule_.leave(device);  // until it is open again
  enter(device, Phase::opening);
  return true;
}

void DeviceSessions::broke(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  tell();
}

void DeviceSessions::closing(std::size_t device, const DeviceReport& totals) {
  const std::lock_guard lock(mutex_);
  Session& session = sessions_[device];
  if (session.lost) return;
  DeviceReport& report = reports_[device];
  report.device_bytes = std::max(report.device_bytes, totals.device_bytes);  // photon maps come while it renders
  for (const auto& [name, stage] : totals.stages) report.stages[name] += stage;
  report.gaps += totals.gaps;
  add_bounces(report.bounces, totals.bounces);
  if (session.units.empty()) enter(device, Phase::closing);
}

void DeviceSessions::ended(std::size_t device) {
  const std::lock_guard lock(mutex_);
  schedule_.leave(device);
  if (sessions_[device].lost) lost_thread_ended();
  enter(device, Phase::ended);
}

// ---- the thread that called render()

void DeviceSessions::set_period(std::uint64_t period) {
  const std::lock_guard lock(mutex_);
  schedule_.set_period(period);
}

void DeviceSessions::open(const std::vector<WorkUnit>& boxes) {
  const std::lock_guard lock(mutex_);
  for (Session& session : sessions_) session.range_begin_s = -1;
  range_begin_s_ = -1;
  schedule_.open(boxes);
  work_.notify_all();
}

void DeviceSessions::set_latest(double latest_s) {
  const std::lock_guard lock(mutex_);
  schedule_.set_latest(latest_s);
}

void DeviceSessions::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  for (std::size_t i = 0; i < sessions_.size(); ++i)
    if (const double at = schedule_.left_out_at(i); at > kReportedLeftOutShare)
      note(i, DeviceEvent::Kind::left_out,
           fmt::format("it was left out of the last {:.0f} % of the work: its units would have been late", 100 * at));
  work_.notify_all();
}

void DeviceSessions::wait(double seconds) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, seconds_of(seconds), [&] { return news_; });
  news_ = false;
}

bool DeviceSessions::counts(const Session& session) const {
  return std::ranges::any_of(session.units, [&](std::uint64_t id) { return schedule_.counts(id); });
}

double DeviceSessions::limit_s(const Session& session) const {
  switch (session.phase) {
    case Phase::opening:
      return kOpeningWatchdogs * watchdog_s_;
    case Phase::working:
      break;
    case Phase::closing:
      return watchdog_s_;
    default:
      return 1e30;
  }
  double expected_s = 0;
  for (const std::uint64_t id : session.units) {
    const std::optional<double> unit_s = schedule_.expected_s(id);
    if (!unit_s && schedule_.counts(id)) return unit_limit_s(watchdog_s_, std::nullopt);
    expected_s += unit_s.value_or(0);
  }
  return unit_limit_s(watchdog_s_, expected_s);
}

double DeviceSessions::unit_limit_s(double watchdog_s, std::optional<double> expected_s) {
  return expected_s ? std::max(watchdog_s, kLateFactor * *expected_s) : kUnknownUnitWatchdogs * watchdog_s;
}

void DeviceSessions::abandon(std::size_t device, DeviceEvent::Kind kind, const std::string& text) {
  Session& session = sessions_[device];
  schedule_.leave(device);
  reports_[device].failures += kind == DeviceEvent::Kind::hung ? session.units.size() : 0;
  session.units.clear();
  session.lost = true;
  if (kind == DeviceEvent::Kind::hung) reports_[device].error = text;
  thread_is_lost();
  if (!text.empty()) note(device, kind, text);
  work_.notify_all();
}

void DeviceSessions::watch() {
  const std::lock_guard lock(mutex_);
  const double now_s = host_seconds(), gap_s = watched_s_ < 0 ? 0 : now_s - watched_s_;
  watched_s_ = now_s;
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    Session& session = sessions_[i];
    if (session.lost || session.phase == Phase::ended) continue;
    const double seconds = session.watched.seconds(session.since_s, now_s, gap_s);
    if (seconds <= limit_s(session)) continue;
    const char* const what = session.phase == Phase::opening   ? "opening it"
                             : session.phase == Phase::working ? "a unit of its work"
                                                               : "closing it";
    const bool after_failure = session.phase == Phase::closing && session.failures_in_a_row > 0;
    abandon(i, DeviceEvent::Kind::hung,
            fmt::format("{}{} did not end within {:.3g} s: it was given up",
                        after_failure ? session.why + "; then " : "", what, seconds));
  }
}

bool DeviceSessions::all_ended() const {
  // A thread that is adding to the film always comes to an end, even when its device was abandoned
  // for the next unit.
  return adding_ == 0 && std::ranges::all_of(sessions_, [](const Session& session) {
           return session.lost || session.phase == Phase::ended;
         });
}

void DeviceSessions::wait_for_threads() {
  const double begin_s = host_seconds();
  while (true) {
    wait(0.01);
    watch();
    const std::lock_guard lock(mutex_);
    if (all_ended()) return;
    if (host_seconds() - begin_s < std::max(kMinPatience_s, kPatienceShare * totals_.render_s)) continue;
    const bool complete = schedule_.complete();
    for (std::size_t i = 0; i < sessions_.size(); ++i) {
      const Session& session = sessions_[i];
      if (session.lost || session.dropped) continue;
      if (session.phase == Phase::opening)  // a compiler may take long, and no work is lost
        abandon(i, DeviceEvent::Kind::late, complete ? "the others had done everything before it was ready" : "");
      if (session.phase == Phase::working && !counts(session))
        abandon(i, DeviceEvent::Kind::late, "it was so late with a unit that another device did it");
    }
  }
}

DeviceSessions::State DeviceSessions::state() {
  const std::lock_guard lock(mutex_);
  if (error_) return State::broken;
  if (adding_ == 0 && schedule_.complete()) return State::done;
  const bool some_left = std::any_of(sessions_.begin(), sessions_.end(), [](const Session& session) {
    return !session.lost && !session.dropped && session.phase != Phase::ended;
  });
  return some_left || adding_ > 0 ? State::working : State::no_device_left;
}

bool DeviceSessions::is_opening() {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(sessions_,
                             [](const Session& session) { return !session.lost && session.phase == Phase::opening; });
}

std::string DeviceSessions::failure_summary() {
  const std::lock_guard lock(mutex_);
  std::string text;
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    if (sessions_.size() == 1) return reports_[i].error;
    text += fmt::format("{}device {}: {}", text.empty() ? "" : "; ", reports_[i].info.selector, reports_[i].error);
  }
  return text;
}

}  // namespace eikon
