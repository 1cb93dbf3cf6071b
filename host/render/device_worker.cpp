// SPDX-License-Identifier: Apache-2.0
#include "render/device_worker.h"

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

/// Units until there are none.
void drive(Crew& crew, std::size_t device, UnitRunner& runner) {
  while (std::optional<Schedule::Dealt> unit = crew.wait_for_unit(device)) {
    runner.begin(unit->unit);
    while (unit) {
      std::optional<Schedule::Dealt> next;
      const UnitResult result = runner.finish([&]() -> std::optional<WorkUnit> {
        next = crew.next_unit(device);
        return next ? std::optional(next->unit) : std::nullopt;
      });
      crew.finished(device, *unit, result);  // while the device works on the next
      unit = next;
    }
  }
}

class WavefrontRunner : public UnitRunner {
 public:
  WavefrontRunner(const WavefrontCrew& crew, std::size_t device, const Execution& execution)
      : pool_(crew.pool),
        lease_(pool_.take(crew.devices[device])),
        wavefront_(follow(*lease_, execution), *crew.packed, crew.features, crew.settings, execution) {}

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
    report.compile_s = lease_->profiler().compile_s;
    report.upload_s = wavefront_.upload_s();
    report.stages = lease_->profiler().totals();
    report.spans = lease_->profiler().spans();
  }
  void discard() override { lease_.discard(); }
  void begin(const WorkUnit& unit) override { wavefront_.begin(unit); }
  UnitResult finish(const Next& next) override {
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
    UnitResult result = wavefront_.finish();
    try {
      if (const std::optional<WorkUnit> unit = next()) wavefront_.begin(*unit);
    } catch (...) {
      failed_ = std::current_exception();  // the result is there none the less
    }
    return result;
  }

 private:
  static Device& follow(Device& device, const Execution& execution) {
    device.profiler().keep_spans(execution.keep_spans);
    return device;
  }

  DevicePool pool_;
  DevicePool::Lease lease_;
  Wavefront wavefront_;
  std::exception_ptr failed_;
};

}  // namespace

void run_device(const std::shared_ptr<Crew>& crew, std::size_t device, const OpenRunner& open) noexcept {
  try {
    for (unsigned shrink = 0;; ++shrink) {
      std::unique_ptr<UnitRunner> runner;
      try {
        runner = open(device, shrink);
        DeviceReport found;
        runner->describe(found);
        crew->opened(device, runner->limits(), found);
        drive(*crew, device, *runner);
        found = {};
        runner->describe(found);
        crew->closing(device, found);
        break;
      } catch (const DeviceError& error) {
        if (runner) {
          runner->discard();
          DeviceReport found;
          runner->describe(found);
          crew->closing(device, found);
        }
        if (!crew->failed(device, error.what())) break;
      }
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
