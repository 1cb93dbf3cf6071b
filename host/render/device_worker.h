// SPDX-License-Identifier: Apache-2.0
// The thread of one device: it opens it, has it work on units until there are none, and starts again when it fails.
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "core/trace.h"
#include "device/device_pool.h"
#include "render/crew.h"

namespace eikon {

/// A device that is ready for units of one scene.
class UnitRunner {
 public:
  /// What to begin next, if anything; it is asked once for each unit.
  using Next = std::function<std::optional<WorkUnit>()>;

  UnitRunner() = default;
  UnitRunner(const UnitRunner&) = delete;
  UnitRunner& operator=(const UnitRunner&) = delete;
  virtual ~UnitRunner() = default;
  [[nodiscard]] virtual UnitLimits limits() const = 0;
  /// config, arithmetic, bytes and times of opening it; stages, gaps and bounces so far.
  virtual void describe(DeviceReport& report) = 0;
  /// The first unit after a pause. throws DeviceError
  virtual void begin(const WorkUnit& unit) = 0;
  /// Begins what `next` says as soon as the device has room for it, and waits for the unit that was begun before that. The result lasts until
  /// the next call. throws DeviceError for the unit that it waits for; what is wrong with the next one is thrown by the next call.
  virtual UnitResult finish(const Next& next) = 0;
  /// A span of the thread that drives it, for --profile.
  [[nodiscard]] virtual TraceScope scope(const char* name) { return {nullptr, Trace::kMain, name}; }
  /// It threw a DeviceError: nobody is to use the device again without opening it anew.
  virtual void discard() {}
};

/// Opens a device. shrink: units should be a quarter as large for each; see unit_shrink.h
/// throws DeviceError
using OpenRunner = std::function<std::unique_ptr<UnitRunner>(std::size_t device, unsigned shrink)>;

/// The thread's whole life. It touches nothing but its arguments, which it shares: see crew.h.
void run_device(const std::shared_ptr<Crew>& crew, std::size_t device, const OpenRunner& open) noexcept;

/// OpenCL devices, with a Wavefront each. `executions`: of each device.
struct WavefrontCrew {
  std::vector<DeviceInfo> devices;
  std::vector<Execution> executions;
  std::shared_ptr<PackedScene> packed;
  Features features;
  Settings settings;
  DevicePool pool;                   // a copy: that it is of may be gone before a thread that hangs
  std::shared_ptr<const void> keep;  // what `packed` refers to
  bool stay = false;                 // the wavefronts stay with the devices, in the pool
};
OpenRunner open_wavefronts(std::shared_ptr<const WavefrontCrew> crew);

}  // namespace eikon
