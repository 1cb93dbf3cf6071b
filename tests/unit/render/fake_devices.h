// SPDX-License-Identifier: Apache-2.0
// Invented devices, which fail, hang or dawdle as a test says, and a render by them.
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include "render/device_sessions.h"
#include "render/device_worker.h"

namespace eikon::test {

inline constexpr Crop kImage{0, 0, 96, 64};
inline constexpr std::uint64_t kSpp = 24;

inline FilmLayout layout() { return {.width = kImage.x1, .height = kImage.y1, .crop = kImage}; }

/// The value of a sample of a pixel, in the film's smallest step.
inline std::uint32_t value(std::uint32_t x, std::uint32_t y, std::uint64_t sample, std::size_t channel) {
  return std::uint32_t((x * 31 + y * 17 + sample * 7 + channel) % 1000);
}

/// It is called when a device is to finish its n-th unit, from 0; it may throw, or sleep.
using Behaviour = std::function<void(std::uint64_t n, const WorkUnit& unit)>;

struct FakeDevice {
  Behaviour unit = [](std::uint64_t, const WorkUnit&) {};
  std::function<void(unsigned shrink)> open = [](unsigned) {};
  std::function<void()> close = [] {};
  double path_s = 2e-7;
  std::uint64_t capacity = 1U << 14, grain = 64;
  bool beside = false;  // its sums are added on another thread
  std::function<bool(std::uint64_t n)> spoils = [](std::uint64_t) { return false; };  // the sums of its n-th unit
  std::uint64_t units = 0;  // over all openings
};

class FakeRunner : public UnitRunner {
 public:
  FakeRunner(FakeDevice& device, unsigned shrink)
      : device_(device), capacity_(std::max<std::uint64_t>(1, device.capacity >> (2 * shrink))) {
    device.open(shrink);
  }
  ~FakeRunner() override { device_.close(); }
  [[nodiscard]] UnitLimits limits() const override { return {capacity_, device_.grain}; }
  [[nodiscard]] bool adds_sums_beside() const override { return device_.beside; }
  void describe(DeviceReport& report) override { report.device_bytes = capacity_; }
  void begin(const WorkUnit& unit) override { unit_ = unit; }
  UnitResult finish(const Next& next) override {
    const WorkUnit unit = unit_;
    EXPECT_LE(unit.path_count(), capacity_);
    std::this_thread::sleep_for(std::chrono::duration<double>(device_.path_s * double(unit.path_count())));
    const std::uint64_t n = device_.units++;
    device_.unit(n, unit);
    // The arrays of the unit before are in use until the next one is asked for.
    if (const std::optional<WorkUnit> then = next()) unit_ = *then;
    pixels_ = unit_pixels(unit.block);
    limbs_.assign(2 * 3 * EK_FILM_LIMBS * pixels_.size(), 0);
    rejected_.assign(2 * pixels_.size(), 0);
    for (std::size_t p = 0; p < pixels_.size(); ++p)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::uint64_t s = unit.sample_begin; s < unit.sample_end; ++s)
          limbs_[((s % 2 * 3 + c) * EK_FILM_LIMBS) * pixels_.size() + p] +=
              value(pixels_[p] & 0xffff, pixels_[p] >> 16, s, c);
    if (device_.spoils(n)) rejected_[0] = 1U << 20;
    UnitResult result;
    result.sums.pixels = pixels_;
    result.sums.pixel_stride = std::uint32_t(pixels_.size());
    result.sums.sample_begin = unit.sample_begin;
    result.sums.sample_end = unit.sample_end;
    result.rays.camera = unit.path_count();
    result.sums.limbs = limbs_;
    result.sums.rejected = rejected_;
    return result;
  }

 private:
  FakeDevice& device_;
  std::uint64_t capacity_;
  WorkUnit unit_;
  std::vector<std::uint32_t> pixels_, limbs_, rejected_;
};

struct Outcome {
  DeviceSessions::State state = DeviceSessions::State::working;
  std::optional<FilmState> film;
  RenderTotals totals;
  std::vector<DeviceReport> devices;
  std::vector<DeviceEvent> events;
  std::exception_ptr error;
  std::string failure_summary;

  [[nodiscard]] bool has(std::size_t device, DeviceEvent::Kind kind) const {
    return std::any_of(events.begin(), events.end(),
                       [&](const DeviceEvent& e) { return e.device == device && e.kind == kind; });
  }
};

/// As render() does. The devices outlive threads that are lost.
inline Outcome run(const std::shared_ptr<std::vector<FakeDevice>>& devices, double watchdog_s = 5) {
  std::vector<DeviceReport> reports(devices->size());
  const auto sessions =
      std::make_shared<DeviceSessions>(reports, FilmState{Film(layout()), SampleSet()}, 32, watchdog_s);
  sessions->open({WorkUnit{kImage, 0, kSpp}});
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < devices->size(); ++i)
    threads.emplace_back([sessions, devices, i] {
      run_device(sessions, i, [devices](std::size_t device, unsigned shrink) {
        return std::make_unique<FakeRunner>((*devices)[device], shrink);
      });
    });
  Outcome outcome;
  while ((outcome.state = sessions->state()) == DeviceSessions::State::working) {
    sessions->wait(0.01);
    sessions->watch();
  }
  sessions->end();
  sessions->wait_for_threads();
  for (std::size_t i = 0; i < threads.size(); ++i) sessions->is_lost(i) ? threads[i].detach() : threads[i].join();
  outcome.totals = sessions->totals();
  outcome.devices = sessions->device_reports();
  outcome.events = sessions->events();
  outcome.error = sessions->error();
  outcome.failure_summary = sessions->failure_summary();
  outcome.film = sessions->film().copy();
  return outcome;
}

inline std::shared_ptr<std::vector<FakeDevice>> devices(std::size_t count) {
  return std::make_shared<std::vector<FakeDevice>>(count);
}

}  // namespace eikon::test
