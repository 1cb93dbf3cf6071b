// SPDX-License-Identifier: Apache-2.0
#include "render/device_worker.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "render/device_trace.h"
#include "render/ready_wavefronts.h"
#include "wavefront/unit_shrink.h"

namespace eikon {
namespace {

/// Units until there are none, or larger ones are to be tried. returns whether that is so
bool drive(Crew& crew, std::size_t device, UnitRunner& runner, UnitShrink& shrink) {
  while (std::optional<Schedule::Dealt> unit = crew.wait_for_unit(device)) {
    const TraceScope rendering = runner.scope("render");
    runner.begin(unit->unit);
    while (unit) {
      std::optional<Schedule::Dealt> next;
      const UnitResult result = runner.finish([&]() -> std::optional<WorkUnit> {
        if (!shrink.is_over(host_seconds())) next = crew.next_unit(device);
        return next ? std::optional(next->unit) : std::nullopt;
      });
      const TraceScope adding = runner.scope("add to film");
      crew.finished(device, *unit, result);  // while the device works on the next
      shrink.finished();
      unit = next;
    }
    if (shrink.is_over(host_seconds())) return true;
  }
  return false;
}

/// From opening a device to closing it. returns whether it is to be opened again
bool attend(Crew& crew, std::size_t device, const OpenRunner& open, UnitShrink& shrink) {
  std::unique_ptr<UnitRunner> runner;
  const auto describe = [&] {
    DeviceReport found;
    runner->describe(found);
    return found;
  };
  try {
    const double begin_s = host_seconds();
    runner = open(device, shrink.times());
    crew.opened(device, runner->limits(), describe());
    shrink.opened(begin_s, host_seconds());
    const bool again = drive(crew, device, *runner, shrink);
    if (again) {
      runner->discard();  // what is open takes memory
      shrink.grow();
    }
    crew.closing(device, describe());
    return again;
  } catch (const DeviceError& error) {
    if (runner) {
      runner->discard();
      crew.closing(device, describe());
    }
    shrink.failed();
    const bool again = crew.failed(device, error.what());
    runner.reset();  // watched as closing
    return again;
  }
}

class WavefrontRunner : public UnitRunner {
 public:
  WavefrontRunner(const WavefrontCrew& crew, std::size_t device, Execution execution)
      : timeline_(execution.trace),
        trace_(timeline_.get(), crew.devices[device]),
        pool_(crew.pool),
        lease_(open(crew.devices[device])),
        stay_(crew.stay),
        wavefront_(ReadyWavefronts::of(lease_).get(*lease_, {crew.packed, crew.keep}, crew.features, crew.settings,
                                                   on_track(std::move(execution)))) {}
  WavefrontRunner(const WavefrontRunner&) = delete;
  WavefrontRunner& operator=(const WavefrontRunner&) = delete;
  ~WavefrontRunner() override {
    if (!stay_) lease_.guest().reset();
    lease_->profiler().follow(nullptr, Trace::kMain, Trace::kMain);  // which others may take next
  }

  [[nodiscard]] UnitLimits limits() const override {
    const WavefrontConfig& config = wavefront_.config();
    // Of a CPU device every work-item gets a chunk; a GPU hides the latency of memory behind many work-items per unit.
    constexpr std::uint64_t kItemsPerUnit = 1024;
    const std::uint64_t grain = config.chunked ? std::uint64_t{config.chunk} * config.workers
                                               : kItemsPerUnit * std::max(lease_->info().compute_units, 1U);
    return {config.capacity(), grain};
  }
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
  [[nodiscard]] TraceScope scope(const char* name) override { return {timeline_.get(), trace_.thread(), name}; }
  void begin(const WorkUnit& unit) override {
    const TraceScope beginning = scope("begin unit");
    if (begin_s_ == 0) begin_s_ = host_seconds();
    wavefront_.begin(unit);
  }
  UnitResult finish(const Next& next) override {
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
    TraceScope driving = scope("launch");
    wavefront_.drive();
    driving.end();
    try {
      if (const std::optional<WorkUnit> unit = next()) begin(*unit);
    } catch (...) {
      failed_ = std::current_exception();  // the result may be there none the less
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
    lease->profiler().follow(timeline_.get(), trace_.queue(), trace_.beside());
    open_s_ = host_seconds() - begin_s;
    return lease;
  }
  Execution on_track(Execution execution) const {
    execution.track = trace_.thread();
    return execution;
  }

  std::shared_ptr<Trace> timeline_;
  DeviceTrace trace_;
  double open_s_ = 0, begin_s_ = 0;
  RayCounts rays_;  // of all units
  DevicePool pool_;
  DevicePool::Lease lease_;
  bool stay_;
  Wavefront& wavefront_;  // of the lease's guest
  std::exception_ptr failed_;
};

}  // namespace

void run_device(const std::shared_ptr<Crew>& crew, std::size_t device, const OpenRunner& open) noexcept {
  try {
    UnitShrink shrink;
    while (attend(*crew, device, open, shrink) && crew->reopening(device)) {
    }
  } catch (...) {
    crew->broke(std::current_exception());
  }
  crew->ended(device);
}

OpenRunner open_wavefronts(std::shared_ptr<const WavefrontCrew> crew) {
  return [crew = std::move(crew)](std::size_t device, unsigned shrink) -> std::unique_ptr<UnitRunner> {
    constexpr std::uint32_t kLeastPool = 1U << 10;
    Execution execution = crew->executions[device];
    if (shrink > 0) {
      const std::uint32_t pool = configure(crew->devices[device], execution).capacity();
      execution.pool = std::max(pool >> std::min(2 * shrink, 31U), std::min(pool, kLeastPool));
    }
    return std::make_unique<WavefrontRunner>(*crew, device, execution);
  };
}

}  // namespace eikon
