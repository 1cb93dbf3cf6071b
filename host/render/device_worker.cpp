// SPDX-License-Identifier: Apache-2.0
#include "render/device_worker.h"

#include <algorithm>
#include <future>
#include <utility>
#include <fmt/format.h>

#include "core/error.h"
#include "render/ready_wavefronts.h"
#include "wavefront/unit_shrink.h"

namespace eikon {
namespace {

/// Adds the sums of a device's units to the film: on the thread that calls, or beside it.
class SumsAdder {
 public:
  SumsAdder(DeviceSessions& sessions, std::size_t device, UnitRunner& runner)
      : sessions_(sessions), device_(device), runner_(runner), beside_(runner.adds_sums_beside()) {}
  /// The arrays of the result must not change before wait().
  void add(const Schedule::Assignment& unit, UnitResult result) {
    const auto add = [this, unit, result = std::move(result)] {
      const TraceScope adding = runner_.adding_scope();
      sessions_.finished(device_, unit, result);
    };
    if (!beside_) return add();
    rethrow();
    adding_ = std::async(std::launch::async, add);
  }
  /// Waits until the sums are added. An error comes with rethrow().
  void wait() const {
    if (adding_.valid()) adding_.wait();
  }
  void rethrow() {
    if (adding_.valid()) adding_.get();
  }

 private:
  DeviceSessions& sessions_;
  std::size_t device_;
  UnitRunner& runner_;
  bool beside_;
  std::future<void> adding_;
};

/// Processes `unit` and those after it, until there is none now, or until larger ones are to be
/// tried.
void process_row_of_units(DeviceSessions& sessions, std::size_t device, UnitRunner& runner, UnitShrink& shrink,
                          std::optional<Schedule::Assignment> unit) {
  SumsAdder adder(sessions, device, runner);
  try {
    const TraceScope rendering = runner.scope("render");
    runner.begin(unit->unit);
    while (unit) {
      std::optional<Schedule::Assignment> next;
      UnitResult result = runner.finish([&]() -> std::optional<WorkUnit> {
        adder.wait();  // the next unit has the arrays of the one before
        if (!shrink.wants_larger_units(host_seconds())) next = sessions.next_unit(device);
        return next ? std::optional(next->unit) : std::nullopt;
      });
      adder.add(*unit, std::move(result));  // while the device works on the next
      shrink.finished();
      unit = next;
    }
  } catch (...) {
    adder.rethrow();  // an error of the film ends the render, and one of the device does not
    throw;
  }
  adder.rethrow();
}

/// Processes units until there are none, or until larger ones are to be tried. returns whether the
/// latter is so
bool process_units(DeviceSessions& sessions, std::size_t device, UnitRunner& runner, UnitShrink& shrink) {
  while (const std::optional<Schedule::Assignment> unit = sessions.wait_for_unit(device)) {
    process_row_of_units(sessions, device, runner, shrink, unit);
    if (shrink.wants_larger_units(host_seconds())) return true;
  }
  return false;
}

/// Opens a device, processes units and closes it. returns  whether it is to be opened again
bool serve(DeviceSessions& sessions, std::size_t device, const OpenRunner& open, UnitShrink& shrink) {
  std::unique_ptr<UnitRunner> runner;
  const auto describe = [&] {
    DeviceReport found;
    runner->describe(found);
    return found;
  };
  try {
    const double begin_s = host_seconds();
    runner = open(device, shrink.times());
    sessions.opened(device, runner->limits(), describe());
    shrink.opened(begin_s, host_seconds());
    const bool again = process_units(sessions, device, *runner, shrink);
    if (again) {
      runner->discard();  // it holds memory that the next opening needs
      shrink.enlarge();
    }
    sessions.closing(device, describe());
    return again;
  } catch (const DeviceError& error) {
    if (runner) {
      runner->discard();
      sessions.closing(device, describe());
    }
    shrink.failed();
    const bool lasts = dynamic_cast<const CompileError*>(&error) != nullptr;
    const bool again = sessions.failed(device, error.what(), lasts);
    runner.reset();  // the watchdog counts this as closing
    return again;
  }
}

/// The tracks of one device in a trace: its queue, the host thread that feeds it and, where it has
/// memory of its own, the transfers beside its work; and its rays per second. With a null trace it
/// does nothing.
class DeviceTrace {
 public:
  DeviceTrace(Trace* trace, const DeviceInfo& info) : trace_(trace) {
    if (trace_ == nullptr) return;
    thread = adding = trace_->add_track(fmt::format("device {}: host thread", info.selector));
    queue = trace_->add_track(fmt::format("device {}: queue of {}", info.selector, info.name));
    if (!info.cpu) beside = trace_->add_track(fmt::format("device {}: read back beside it", info.selector));
    rate_ = fmt::format("Mrays/s, device {}", info.selector);
  }

  /// so_far: rays of all units so far; the first unit began at begin_s, the last one ended at now_s
  void count_rays(const RayCounts& so_far, double begin_s, double now_s) {
    const double from_s = std::max(counted_s_, begin_s);
    if (trace_ == nullptr || now_s <= from_s) return;
    trace_->count(rate_, from_s, now_s, 1e-6 * double(so_far.total() - counted_) / (now_s - from_s));
    counted_s_ = now_s;
    counted_ = so_far.total();
  }

  /// Sums are added beside the device's thread.
  void add_beside(const DeviceInfo& info) {
    if (trace_ != nullptr) adding = trace_->add_track(fmt::format("device {}: sums to film", info.selector));
  }

  Trace::Track thread = Trace::kMain, adding = Trace::kMain, queue = Trace::kMain, beside = Trace::kMain;

 private:
  Trace* trace_;
  std::string rate_;
  double counted_s_ = 0;
  std::uint64_t counted_ = 0;
};

class WavefrontRunner : public UnitRunner {
 public:
  WavefrontRunner(const WavefrontDevices& devices, std::size_t device, Execution execution)
      : timeline_(execution.trace),
        trace_(timeline_.get(), devices.devices[device]),
        pool_(devices.pool),
        lease_(open(devices.devices[device])),
        stay_(devices.stay),
        wavefront_(ReadyWavefronts::of(lease_).get(lease_, devices.packed, devices.features, devices.settings,
                                                   on_track(std::move(execution)))) {
    if (adds_sums_beside()) trace_.add_beside(lease_->info());
  }
  WavefrontRunner(const WavefrontRunner&) = delete;
  WavefrontRunner& operator=(const WavefrontRunner&) = delete;
  ~WavefrontRunner() override {
    if (!stay_) lease_.guest().reset();
    // Other renders may take the device next.
    lease_->profiler().follow(nullptr, Trace::kMain, Trace::kMain);
  }

  [[nodiscard]] UnitLimits limits() const override { return unit_limits(wavefront_.config(), lease_->info()); }
  void describe(DeviceReport& report) override {
    report.config = wavefront_.config();
    report.arithmetic = wavefront_.arithmetic();
    report.device_bytes = wavefront_.device_bytes();
    const Profiler& profiler = lease_->profiler();
    report.open_s = open_s_;
    report.compile_s = profiler.compile_s;
    report.upload_s = wavefront_.upload_s();
    if (const auto uploads = profiler.setup().find("upload"); uploads != profiler.setup().end())
      report.upload_bytes = uploads->second.bytes;
    report.stages = profiler.totals();
    report.gaps = profiler.gaps();
    report.bounces = wavefront_.bounces();
  }
  void discard() override { lease_.discard(); }
  /// throws InputError unless the device has this class, or it is empty
  void require_arithmetic(const std::string& wanted) const {
    const std::string here = wavefront_.arithmetic().name();
    if (wanted.empty() || wanted == here) return;
    throw InputError(
        fmt::format("the pilot's arithmetic class is {}, and device {} has {}: leave out --pilot, or let it "
                    "name another file",
                    wanted, lease_->info().selector, here));
  }
  [[nodiscard]] bool adds_sums_beside() const override { return !wavefront_.config().chunked; }
  [[nodiscard]] TraceScope scope(const char* name) override { return {timeline_.get(), trace_.thread, name}; }
  [[nodiscard]] TraceScope adding_scope() override { return {timeline_.get(), trace_.adding, "add to film"}; }
  void begin(const WorkUnit& unit) override {
    const TraceScope beginning = scope("begin unit");
    if (begin_s_ == 0) begin_s_ = host_seconds();
    wavefront_.begin(unit);
  }
  UnitResult finish(const Next& next) override {
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
    TraceScope driving = scope("launch");
    wavefront_.launch_rest();
    driving.end();
    try {
      if (const std::optional<WorkUnit> unit = next()) begin(*unit);
    } catch (...) {
      failed_ = std::current_exception();  // the result of the unit before may be good all the same
    }
    TraceScope waiting = scope("wait");
    UnitResult result = wavefront_.finish();
    waiting.end();
    rays_ += result.rays;
    trace_.count_rays(rays_, begin_s_, host_seconds());
    return result;
  }

 private:
  DevicePool::Lease open(const DeviceInfo& info) {
    const TraceScope opening = scope("open");
    const double begin_s = host_seconds();
    DevicePool::Lease lease = pool_.take(info);
    lease->profiler().follow(timeline_.get(), trace_.queue, trace_.beside);
    open_s_ = host_seconds() - begin_s;
    return lease;
  }
  Execution on_track(Execution execution) const {
    execution.track = trace_.thread;
    return execution;
  }

  std::shared_ptr<Trace> timeline_;
  DeviceTrace trace_;
  double open_s_ = 0, begin_s_ = 0;
  RayCounts rays_;  // of all units
  DevicePool pool_;
  DevicePool::Lease lease_;
  bool stay_;
  Wavefront& wavefront_;  // owned by the lease's guest
  std::exception_ptr failed_;
};

}  // namespace

UnitLimits unit_limits(const WavefrontConfig& config, const DeviceInfo& device) {
  // A GPU hides the latency of memory behind many work-items per compute unit.
  constexpr std::uint64_t kItemsPerUnit = 1024;
  constexpr double kPass_s = 1;  // a picture without the rest of its samples is that of a second later at most
  UnitLimits limits{.capacity = config.capacity()};
  limits.least_block = kBlockPixels;
  limits.most_block = std::max(config.pixels, kBlockPixels);
  // On a CPU every work-item gets a chunk.
  limits.grain = config.chunked ? std::uint64_t{config.chunk} * config.workers
                                : kItemsPerUnit * std::max(device.compute_units, 1U);
  limits.pass_s = kPass_s;
  return limits;
}

void run_device(const std::shared_ptr<DeviceSessions>& sessions, std::size_t device, const OpenRunner& open) noexcept {
  try {
    UnitShrink shrink;
    while (serve(*sessions, device, open, shrink) && sessions->reopening(device)) {
    }
  } catch (...) {
    sessions->broke(std::current_exception());
  }
  sessions->ended(device);
}

std::vector<DeviceInfo> devices_of(DevicePool& pool, const Execution& execution, std::vector<std::string>* notes) {
  std::vector<DeviceInfo> devices = pool.select(execution.devices, execution.threads, notes);
  // A planned fault may make a device slower than it is, by its own times.
  for (DeviceInfo& info : devices) info.timed = execution.timed || info.fault != nullptr;
  return devices;
}

std::uint32_t block_side(const WavefrontDevices& devices) {
  std::uint32_t side = kBlockSide;
  for (std::size_t i = 0; i < devices.devices.size(); ++i) {
    const Execution& execution = devices.executions[i];
    if (execution.block != 0) return execution.block;
    // A device of large units cuts the blocks that it needs from the whole picture.
    const Crop& crop = devices.settings.crop;
    if (configure(devices.devices[i], execution).pixels > kBlockPixels)
      side = std::max({side, crop.width(), crop.height()});
  }
  return side;
}

OpenRunner open_wavefronts(std::shared_ptr<const WavefrontDevices> devices) {
  return [devices = std::move(devices)](std::size_t device, unsigned shrink) -> std::unique_ptr<UnitRunner> {
    Execution execution = devices->executions[device];
    if (shrink > 0)
      execution.unit_paths = shrunk_unit(configure(devices->devices[device], execution).capacity(), shrink);
    auto runner = std::make_unique<WavefrontRunner>(*devices, device, execution);
    if (device == devices->pilot_device) runner->require_arithmetic(devices->pilot_arithmetic);
    return runner;
  };
}

}  // namespace eikon
