// SPDX-License-Identifier: Apache-2.0
// The state that the threads of one render share: the schedule, the film, the phase of each device
// and what went wrong. It knows nothing of OpenCL. Device threads (device_worker.h) and the thread
// that called render() call it; host/README.md draws the states of a device.
//
// A device's thread may hang in its driver for ever. Its session is then abandoned: its units go to
// other devices, nothing that it brings later counts, and all that the thread may touch lives as
// long as it does, because threads hold this by shared pointers.
#pragma once
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/watched_phase.h"
#include "render/device_report.h"
#include "render/film_store.h"
#include "render/schedule.h"

namespace eikon {

class DeviceSessions {
 public:
  /// Opening a device may take so many times the watchdog's seconds, because the compilers of some
  /// drivers take minutes.
  static constexpr double kOpeningWatchdogs = 60;
  /// The most seconds that units may take. expected_s: what they are likely to take; nothing while
  /// no rate is known
  [[nodiscard]] static double unit_limit_s(double watchdog_s, std::optional<double> expected_s);
  /// devices     what is known of them; one with an error takes no part and has no thread
  /// watchdog_s  a unit may take the larger of that and 20 times what is expected, or 6 times that
  ///             while no rate is known
  DeviceSessions(std::vector<DeviceReport> devices, FilmState begin, std::uint32_t block, double watchdog_s);

  // ---- for device threads

  void opened(std::size_t device, const UnitLimits& limits, const DeviceReport& found);
  /// Blocks until there is a unit for the device; nothing means that the device is to be closed.
  [[nodiscard]] std::optional<Schedule::Assignment> wait_for_unit(std::size_t device);
  /// The unit that the device can have now, if there is one.
  [[nodiscard]] std::optional<Schedule::Assignment> next_unit(std::size_t device);
  /// Adds a unit's sums to the film, unless another device was first.
  void finished(std::size_t device, const Schedule::Assignment& assignment, const UnitResult& result);
  /// The device threw a DeviceError: its units go to other devices, and it is to be closed.
  /// lasts    another attempt would end alike
  /// returns  whether it is to be opened again, for smaller units
  [[nodiscard]] bool failed(std::size_t device, const std::string& why, bool lasts = false);
  /// An error that no device caused ends the render.
  void broke(std::exception_ptr error);
  /// The device is about to be closed; `totals` has its stages, gaps and bounces.
  void closing(std::size_t device, const DeviceReport& totals);
  /// The device is closed and would be opened again. returns  false when it is no longer needed
  [[nodiscard]] bool reopening(std::size_t device);
  /// The device's thread ends.
  void ended(std::size_t device);

  // ---- for the thread that called render()

  /// Adds work for the devices.
  void open(const std::vector<WorkUnit>& boxes);
  /// Before the first open(): no unit will cross a multiple of so many samples
  /// (UnitPool::set_period).
  void set_period(std::uint64_t period);
  /// From now on no unit is assigned that should end later, on the clock of host_seconds().
  void set_latest(double latest_s);
  /// From now on no unit is assigned.
  void end();
  /// Returns when the caller may want to look at state(), or after so long.
  void wait(double seconds);
  /// Abandons threads that hang; to be called often. A long pause between two calls means that the
  /// whole process was stopped, so devices are not blamed for it.
  void watch();
  /// After end(): waits until each unit under way has ended or its thread is abandoned. It does not
  /// wait long for units that no longer count.
  void wait_for_threads();

  enum class State {
    working,
    done,    // all work that was opened
    broken,  // broke() was called
    no_device_left,
  };
  [[nodiscard]] State state();
  /// Some device is being opened.
  [[nodiscard]] bool is_opening();
  [[nodiscard]] std::exception_ptr error() { return now(error_); }
  /// The error of each device, for a message when none is left.
  [[nodiscard]] std::string failure_summary();
  [[nodiscard]] RenderTotals totals() { return now(totals_); }
  [[nodiscard]] std::vector<DeviceReport> device_reports() { return now(reports_); }
  [[nodiscard]] std::vector<DeviceEvent> events() { return now(events_); }
  [[nodiscard]] FilmStore& film() { return film_; }
  /// The device's thread was abandoned, so it must not be joined.
  [[nodiscard]] bool is_lost(std::size_t device) { return now(sessions_[device].lost); }

 private:
  enum class Phase { opening, idle, working, closing, ended };
  struct Session {
    Phase phase = Phase::opening;
    double since_s = 0;  // begin of the phase, or of the unit in hand
    WatchedPhase watched;
    bool lost = false;                 // its thread was abandoned
    bool dropped = false;              // it failed for good
    std::vector<std::uint64_t> units;  // ids of its units, in the order of assignment
    bool was_open = false;             // it was open at least once
    unsigned failures_in_a_row = 0;
    unsigned failures = 0;      // since enough good units made up for the ones before
    unsigned successes = 0;     // good units since it failed last
    unsigned noted = 0;         // failures that became events
    std::string why;            // message of its last failure
    double range_begin_s = -1;  // begin of its work on what open() added last; -1: it has not begun
    double busy_before_s = 0;   // DeviceReport::busy_s at that time
  };

  [[nodiscard]] std::optional<Schedule::Assignment> assign(std::size_t device);
  void count_unit(std::size_t device, const WorkUnit& unit, const UnitResult& result);
  void count_time(std::size_t device, double now_s);
  void enter(std::size_t device, Phase phase);
  void tell();  // wakes wait()
  /// A copy of what the mutex guards.
  template <class T>
  [[nodiscard]] T now(const T& guarded) {
    const std::lock_guard lock(mutex_);
    return guarded;
  }
  void abandon(std::size_t device, DeviceEvent::Kind kind, const std::string& text);
  [[nodiscard]] double limit_s(const Session& session) const;
  [[nodiscard]] bool counts(const Session& session) const;
  void note(std::size_t device, DeviceEvent::Kind kind, const std::string& text);
  [[nodiscard]] bool all_ended() const;

  FilmStore film_;
  const double watchdog_s_;
  std::mutex mutex_;  // guards all below
  std::condition_variable work_, changed_;
  Schedule schedule_;
  std::vector<Session> sessions_;
  std::vector<DeviceReport> reports_;
  std::vector<DeviceEvent> events_;
  RenderTotals totals_;
  std::size_t adding_ = 0;  // threads that are adding to the film
  bool ended_ = false;      // end() was called
  bool news_ = false;       // for wait(), since it returned last
  std::exception_ptr error_;
  double range_begin_s_ = -1;     // begin of the work on what open() added last; -1: it has not begun
  double rendered_before_s_ = 0;  // RenderTotals::render_s at that time
  double watched_s_ = -1;  // time of the last call of watch()
};

}  // namespace eikon
