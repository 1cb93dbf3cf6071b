// SPDX-License-Identifier: Apache-2.0
// Probes whether a device reads what lies in its memory. Every device is probed before a render
// trusts it, which takes about a millisecond.
#pragma once
#include <string>

#include "core/error.h"
#include "device/device.h"

namespace eikon {

/// The driver gives wrong results, so trying again is of no use.
struct UntrustedDevice : DeviceError {
  explicit UntrustedDevice(const std::string& message) : DeviceError(message) {}
};

/// The buffers of the memory probe (kernels/probe/canary.h).
class Canary {
 public:
  /// Adds its buffers to `arguments`. throws DeviceError
  Canary(Device& device, Arguments& arguments);
  /// To be called after a kernel with the probe has run.
  /// throws UntrustedDevice; DeviceError when the results cannot be read
  void require(Device& device) const;

 private:
  Buffer out_;
};

/// Runs kernel `canary` of `program`. throws UntrustedDevice; DeviceError when it cannot run
void require_canary(Device& device, const Program& program);

/// Opens a device and runs the probe alone, with the lanes that fit the device.
/// returns  whether both succeeded
[[nodiscard]] bool passes_canary(const DeviceInfo& info);

}  // namespace eikon
