// SPDX-License-Identifier: Apache-2.0
// What the threads of one render share: the schedule, the film, what each device is at, and what went wrong. It knows nothing of
// OpenCL; device threads (device_worker.h) and the thread that called render() call it.
//
// A device's thread may hang in its driver for ever. It is given up then: its unit is dealt again, nothing that it brings later
// counts, and all that it may touch lives as long as it does, which is why threads hold the crew by shared pointers.
#pragma once
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "render/device_report.h"
#include "render/film_store.h"
#include "render/schedule.h"

namespace eikon {

class Crew {
 public:
  static constexpr double kOpening = 60;  // times the watchdog's seconds: compilers of some drivers take minutes
  /// devices: what is known of them; one with an error takes no part, and has no thread
  /// watchdog_s: a unit may take that long, or 20 times what is expected; 6 times that while nothing is known of the device; opening
  /// it may take 60 times that
  Crew(std::vector<DeviceReport> devices, FilmState begin, std::uint32_t block, double watchdog_s);

  // ---- for device threads

  void opened(std::size_t device, const UnitLimits& limits, const DeviceReport& found);
  /// Blocks while there may be a unit later. Nothing: the device is to be closed.
  [[nodiscard]] std::optional<Schedule::Dealt> wait_for_unit(std::size_t device);
  /// What is there now.
  [[nodiscard]] std::optional<Schedule::Dealt> next_unit(std::size_t device);
  /// Adds a unit to the film, if it counts.
  void finished(std::size_t device, const Schedule::Dealt& dealt, const UnitResult& result);
  /// The device threw a DeviceError: what it had is dealt again, and it is to be closed. returns whether to open it again, for smaller
  /// units
  [[nodiscard]] bool failed(std::size_t device, const std::string& why);
  /// Something that is not the device's fault: the render ends with it.
  void broke(std::exception_ptr error);
  /// The device will be closed: the last that can be said of it.
  void closing(std::size_t device, const DeviceReport& totals);
  /// It is closed, and will be opened again. false: it is needed no more
  [[nodiscard]] bool reopening(std::size_t device);
  /// The thread ends.
  void ended(std::size_t device);

  // ---- for the thread that called render()

  /// Work for the devices.
  void open(const std::vector<WorkUnit>& boxes);
  /// No more units are dealt.
  void end();
  /// Until something has changed that the caller may want to know of, or for so long.
  void wait(double seconds);
  /// Gives up threads that hang; to be called often. While it is not called for long, nobody is late: the process was stopped.
  void watch();
  /// After end(): what is under way comes to its end, or is given up. What no longer counts is not waited for long.
  void wait_for_threads();

  enum class State {
    working,
    done,      // with what was opened
    broken,    // somebody called broke()
    unmanned,  // no device is left
  };
  [[nodiscard]] State state();
  /// Whether some device is being opened.
  [[nodiscard]] bool is_opening();
  [[nodiscard]] std::exception_ptr error();
  /// When no device is left: why, for each.
  [[nodiscard]] std::string last_words();

  struct Totals {
    std::uint64_t samples = 0;
    double first_sample_s = 0, render_s = 0;
    RayCounts rays;
    std::uint64_t given_up = 0;
    std::uint32_t given_up_surfaces = 0;
    std::uint64_t nonfinite = 0, saturated = 0;
    std::vector<RejectedSample> rejected;  // the first few
  };
  [[nodiscard]] Totals totals();
  [[nodiscard]] std::vector<DeviceReport> device_reports();
  [[nodiscard]] std::vector<DeviceEvent> events();
  [[nodiscard]] FilmStore& film() { return film_; }
  /// Whether the device's thread was given up, so that it must not be joined.
  [[nodiscard]] bool is_lost(std::size_t device);

 private:
  enum class Phase { opening, idle, working, closing, ended };
  struct Post {
    Phase phase = Phase::opening;
    double since_s = 0;                         // the phase, or the unit in hand
    double excused_since_s = 0, excused_s = 0;  // of the time since then, while the process was stopped
    bool lost = false, dropped = false;
    std::vector<std::uint64_t> units;              // ids, in the order in which they were dealt
    unsigned failures_in_a_row = 0, failures = 0;  // failures: since the last that was forgiven
    std::string why;                               // it failed last
    unsigned successes = 0, noted = 0;             // units since it failed; failures that events tell of
    bool was_open = false;
    double stretch_begin_s = -1, busy_before_s = 0;  // of the work opened last; before that
  };

  [[nodiscard]] std::optional<Schedule::Dealt> deal(std::size_t device);
  void enter(std::size_t device, Phase phase);
  void give_up(std::size_t device, DeviceEvent::Kind kind, const std::string& text);
  [[nodiscard]] double limit_s(const Post& post) const;
  [[nodiscard]] bool counts(const Post& post) const;
  void note(std::size_t device, DeviceEvent::Kind kind, const std::string& text);
  [[nodiscard]] bool all_ended() const;

  FilmStore film_;
  const double watchdog_s_;
  std::mutex mutex_;  // guards all below
  std::condition_variable work_, changed_;
  Schedule schedule_;
  std::vector<Post> posts_;
  std::vector<DeviceReport> reports_;
  std::vector<DeviceEvent> events_;
  Totals totals_;
  std::size_t adding_ = 0;  // threads that add to the film
  bool ended_ = false, news_ = false;
  std::exception_ptr error_;
  double stretch_begin_s_ = -1, rendered_before_s_ = 0;
  double watched_s_ = -1;  // when watch() was called last
};

}  // namespace eikon
