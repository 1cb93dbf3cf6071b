// SPDX-License-Identifier: Apache-2.0
// The thread of one device: it opens the device, processes units until there are none, and starts
// again after a failure.
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "core/trace.h"
#include "device/device_pool.h"
#include "render/device_sessions.h"

namespace eikon {

/// An open device that renders units of one scene. Tests put fake devices behind this interface.
class UnitRunner {
 public:
  /// Returns the unit to begin next, if any; finish() calls it once.
  using Next = std::function<std::optional<WorkUnit>()>;

  UnitRunner() = default;
  UnitRunner(const UnitRunner&) = delete;
  UnitRunner& operator=(const UnitRunner&) = delete;
  virtual ~UnitRunner() = default;
  [[nodiscard]] virtual UnitLimits limits() const = 0;
  /// Fills in config, arithmetic, bytes and times of opening; stages, gaps and bounces so far.
  virtual void describe(DeviceReport& report) = 0;
  /// Begins the first unit after a pause. throws DeviceError
  virtual void begin(const WorkUnit& unit) = 0;
  /// Begins the unit of `next` as soon as the device has room for it, and waits for the unit that
  /// was begun before. The result is valid until the next call asks for a unit. throws DeviceError
  /// for the unit that it waits for; an error of the next unit comes with the next call.
  virtual UnitResult finish(const Next& next) = 0;
  /// True if the sums of units are to be added on another thread: units are driven launch by
  /// launch, so that the device would idle while its thread does anything else.
  [[nodiscard]] virtual bool adds_sums_beside() const { return false; }
  /// Opens a span on the track of the device's thread, for --profile.
  [[nodiscard]] virtual TraceScope scope(const char* name) { return {nullptr, Trace::kMain, name}; }
  /// Opens one on the track of the thread that adds sums.
  [[nodiscard]] virtual TraceScope adding_scope() { return scope("add to film"); }
  /// To be called after a DeviceError: nobody will use the device again without opening it anew.
  virtual void discard() {}
};

/// The sizes of units that suit a device which is driven as configured.
[[nodiscard]] UnitLimits unit_limits(const WavefrontConfig& config, const DeviceInfo& device);

/// Opens a device. shrink: how many times the size of units is to be divided by four
/// (unit_shrink.h). throws DeviceError
using OpenRunner = std::function<std::unique_ptr<UnitRunner>(std::size_t device, unsigned shrink)>;

/// The body of a device's thread. It touches nothing but its arguments, which it shares
/// (device_sessions.h).
void run_device(const std::shared_ptr<DeviceSessions>& sessions, std::size_t device, const OpenRunner& open) noexcept;

/// Returns the devices that are asked for, with times if those are. notes, throws: as
/// DevicePool::select()
[[nodiscard]] std::vector<DeviceInfo> devices_of(DevicePool& pool, const Execution& execution,
                                                 std::vector<std::string>* notes = nullptr);

/// The input for a Wavefront on each OpenCL device.
struct WavefrontDevices {
  std::vector<DeviceInfo> devices;
  std::vector<Execution> executions;  // one per device, with the units that fit it
  std::shared_ptr<PackedScene> packed;
  Features features;
  Settings settings;
  FilmLayout film;  // of the image, with channels for light paths even if a pilot finds that there are to be none
  DevicePool pool;  // a copy, because a thread that hangs may outlive the original
  bool stay = false;  // wavefronts stay with their devices in the pool
  /// The arithmetic class that this device must have, because a pilot of it was loaded; empty: any.
  std::string pilot_arithmetic{};
  std::size_t pilot_device = 0;
  std::uint32_t asked_unit_paths = 0;  // Execution::unit_paths before units were fitted
};
/// The largest side of the blocks that the picture is divided into before a device has cut its unit
/// from one.
[[nodiscard]] std::uint32_t block_side(const WavefrontDevices& devices);
/// The runners throw InputError where the device is not of the class that the pilot needs.
OpenRunner open_wavefronts(std::shared_ptr<const WavefrontDevices> devices);

}  // namespace eikon
