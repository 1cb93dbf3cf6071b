// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/pilot_thread.h"

#include <algorithm>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <utility>

#include "core/abandonable_task.h"
#include "core/clock.h"
#include "core/watched_phase.h"
#include "render/device_sessions.h"
#include "render/pilot/pilot.h"
#include "wavefront/memory_need.h"
#include "wavefront/unit_shrink.h"

namespace eikon {
namespace {

constexpr unsigned kAttempts = 3;         // on one device, as units have before it is dropped
constexpr double kPatience_s = 0.1;       // with a thread whose pilot nobody wants any more

/// A call into the device's driver does not return. The device is not tried again, unlike one that
/// only failed.
struct HungDevice : DeviceError {
  using DeviceError::DeviceError;
};

struct NotWanted {};  // thrown on the pilot's thread to end it

/// A pilot that is being rendered. The thread that renders it and the one that waits share it,
/// because the former may hang in a driver and outlive the latter.
/// shrink  how many times units are made smaller, after attempts that failed
///         (wavefront/unit_shrink.h)
class PilotWork : public PilotSteps {
 public:
  PilotWork(const WavefrontDevices& devices, std::size_t device, unsigned shrink)
      : devices_(devices),
        info_(devices.devices[device]),
        execution_(devices.executions[device]),
        since_s_(host_seconds()),
        polled_s_(since_s_) {
    if (shrink == 0) return;
    const std::uint32_t most_paths = shrunk_unit(kMaxPilotUnitPaths, shrink);
    execution_.unit_paths = execution_.unit_paths == 0 ? most_paths : std::min(execution_.unit_paths, most_paths);
  }

  // ---- for the thread that renders

  /// throws DeviceError
  void run() {
    try {
      // A device that is left by an exception does not go back to its pool.
      DevicePool::Lease lease = devices_.pool.take(info_);
      pilot_ = run_pilot(lease, devices_.packed, devices_.features, devices_.settings, execution_, *this);
      if (!devices_.stay) lease.guest().reset();
    } catch (const NotWanted&) {
    }
  }
  void begin_unit(std::uint64_t paths) override {
    const std::lock_guard lock(mutex_);
    if (unwanted_) throw NotWanted();
    is_open_ = true;
    paths_ = paths;
    since_s_ = host_seconds();
  }
  void end_unit() override {
    const std::lock_guard lock(mutex_);
    done_paths_ += paths_;
    const double now_s = host_seconds();
    done_s_ += now_s - std::exchange(since_s_, now_s);
    paths_ = 0;
  }

  // ---- for the thread that waits

  /// Returns true if nobody should wait any longer. To be called again and again.
  [[nodiscard]] bool gives_up(const std::atomic<bool>& stop, double latest_s) {
    const std::lock_guard lock(mutex_);
    const double now_s = host_seconds();
    if (!unwanted_ && (stop.load() || now_s >= latest_s)) unwanted_ = true, unwanted_s_ = now_s;
    return is_late(now_s) || (unwanted_ && now_s - unwanted_s_ > kPatience_s);
  }
  /// Takes what run() has rendered, once it has ended; nothing if nobody wanted it any more.
  [[nodiscard]] std::optional<Pilot> result() { return std::move(pilot_); }
  /// After gives_up() has returned true: says what hangs, or is empty if the thread is only left
  /// because nobody wants its pilot any more.
  [[nodiscard]] std::string why_lost() const { return why_; }

 private:
  /// Returns true if the device hangs, and then says in why_ what it was doing.
  [[nodiscard]] bool is_late(double now_s) {
    const double gap_s = now_s - std::exchange(polled_s_, now_s);
    const double watchdog_s = execution_.watchdog_s;
    // Beside units the device gets tables and the host learns from what was found. That takes far
    // less than a unit of unknown duration may.
    std::optional<double> expected_s;
    if (paths_ > 0 && done_paths_ > 0) expected_s = done_s_ * double(paths_) / double(done_paths_);
    const double limit_s = is_open_ ? DeviceSessions::unit_limit_s(watchdog_s, expected_s)
                                    : DeviceSessions::kOpeningWatchdogs * watchdog_s;
    const double seconds = phase_.seconds(since_s_, now_s, gap_s);
    if (seconds <= limit_s) return false;
    const char* const what = !is_open_    ? "opening it"
                             : paths_ > 0 ? "a unit of the pilot"
                                          : "the pilot's work beside its units";
    why_ = fmt::format("{} did not end within {:.3g} s: it was given up", what, seconds);
    return true;
  }

  WavefrontDevices devices_;  // a copy, because the thread may be lost
  DeviceInfo info_;
  Execution execution_;
  std::optional<Pilot> pilot_;
  std::mutex mutex_;  // guards all below
  bool is_open_ = false, unwanted_ = false;
  double unwanted_s_ = 0;
  double since_s_, polled_s_;  // begin of opening, of the unit, or of the time after it; when is_late() was called last
  WatchedPhase phase_;
  std::uint64_t paths_ = 0, done_paths_ = 0;  // of the unit under way, 0 while there is none; of those before
  double done_s_ = 0;
  std::string why_;
};

/// Returns nothing if the pilot was not wanted any more. throws DeviceError, HungDevice
std::optional<Pilot> pilot_on(const WavefrontDevices& devices, std::size_t device, unsigned shrink,
                              const std::atomic<bool>& stop, double latest_s) {
  if (stop.load() || host_seconds() >= latest_s) return std::nullopt;
  const auto work = std::make_shared<PilotWork>(devices, device, shrink);
  AbandonableTask task([work] { work->run(); });
  if (task.wait([&] { return work->gives_up(stop, latest_s); })) return work->result();
  if (const std::string why = work->why_lost(); !why.empty()) throw HungDevice(why);
  return std::nullopt;
}

/// Makes the units of devices smaller where what guiding needs beside the scene has no room else.
/// Returns a line about the first device that has no room even then, and leaves all as it was;
/// empty if all have.
std::string lacking_memory(const GuideTable& table, WavefrontDevices& devices,
                           const std::vector<DeviceReport>& prepared) {
  Features guided = devices.features;
  guided.set_guiding(true, false);
  std::vector<Execution> executions = devices.executions;
  for (std::size_t i = 0; i < prepared.size(); ++i) {
    if (!prepared[i].error.empty()) continue;
    const DeviceInfo& info = devices.devices[i];
    Execution& own = executions[i];
    own.unit_paths = devices.asked_unit_paths;
    own = fit_units(*devices.packed, info, guided, devices.settings, own, {.beside_bytes = table.bytes()});
    const std::uint64_t need = memory_need(*devices.packed, configure(info, own), guided, devices.settings).total();
    const std::uint64_t available = available_bytes(info, own);
    if (need + table.bytes() > available)
      return fmt::format(
          "path guiding is off: with its tables the render would take {:.1f} MB of device {}, which has {:.1f} MB "
          "(allow more memory to have it)",
          double(need + table.bytes()) / 0x1p20, info.selector, double(available) / 0x1p20);
  }
  devices.executions = std::move(executions);
  return {};
}

void use_pilot(Pilot pilot, WavefrontDevices& devices, const std::vector<DeviceReport>& prepared,
               RenderReport& report) {
  if (pilot.table != nullptr)
    if (const std::string line = lacking_memory(*pilot.table, devices, prepared); !line.empty()) {
      report.notes.push_back(line);
      pilot.table = nullptr;
      pilot.report.roulette_depth = 0;
    }
  apply(pilot, devices.features, devices.settings);
  report.pilot = pilot.report;
}

}  // namespace

void prepare_pilot(WavefrontDevices& devices, std::vector<DeviceReport>& prepared, const std::atomic<bool>& stop,
                   const RenderHooks& hooks, RenderReport& report) {
  if (!wants_pilot(devices.features, devices.settings)) return;
  std::optional<Pilot> pilot = hooks.pilot ? hooks.pilot() : std::nullopt;
  if (pilot) {
    if (pilot->light_aim != nullptr && pilot->light_aim->target_count() != devices.packed->light_targets.size())
      throw InputError(
          fmt::format("the pilot that was made before aims light paths at {} targets, and there are {}; make it anew",
                      pilot->light_aim->target_count(), devices.packed->light_targets.size()));
    const auto is_able = [](const DeviceReport& device) { return device.error.empty(); };
    devices.pilot_device = std::size_t(std::ranges::find_if(prepared, is_able) - prepared.begin());
    devices.pilot_arithmetic = pilot->report.arithmetic;
    return use_pilot(*pilot, devices, prepared, report);
  }
  std::vector<std::string> errors;  // each once, however many attempts it ended
  const auto failed = [&](std::size_t device, const DeviceError& error) {
    const std::string line =
        fmt::format("the pilot failed on device {}: {}", devices.devices[device].selector, error.what());
    if (!errors.empty() && errors.back() == line) return;
    errors.push_back(line);
    report.notes.push_back(line);
  };
  for (std::size_t i = 0; i < prepared.size(); ++i)
    for (unsigned attempt = 0; attempt < kAttempts && prepared[i].error.empty(); ++attempt) try {
        pilot = pilot_on(devices, i, attempt, stop, hooks.latest_s);
        report.pilot.cut_short = !pilot;
        if (!pilot) return;
        use_pilot(*pilot, devices, prepared, report);
        if (hooks.pilot_done) hooks.pilot_done(*pilot);
        return;
      } catch (const HungDevice& error) {
        failed(i, error);
        prepared[i].error = error.what();
        devices.pool.abandon(devices.devices[i], error.what());
      } catch (const CompileError& error) {
        failed(i, error);
        break;
      } catch (const DeviceError& error) {
        failed(i, error);
      }
  throw DeviceError(fmt::format("{}; --guiding off renders without a pilot", fmt::join(errors, "; ")));
}

}  // namespace eikon
