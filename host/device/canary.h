// SPDX-License-Identifier: Apache-2.0
// Is what a device reads what lies in its memory? Asked of every device before a render trusts it; costs about a millisecond.
#pragma once
#include <string>

#include "core/error.h"
#include "device/device.h"

namespace eikon {

/// The driver gives wrong results; trying again is of no use.
struct UntrustedDevice : DeviceError {
  explicit UntrustedDevice(const std::string& message) : DeviceError(message) {}
};

/// What the memory probe reads and writes (kernels/probe/canary.h).
class Canary {
 public:
  /// Puts its buffers among `arguments`. throws DeviceError
  Canary(Device& device, Arguments& arguments);
  /// After a kernel with the probe in it has run. throws UntrustedDevice, and DeviceError when nothing can be read
  void require(Device& device) const;

 private:
  Buffer out_;
};

/// Runs kernel `canary`, which `program` holds. throws UntrustedDevice, and DeviceError when it cannot be run
void require_canary(Device& device, const Program& program);

/// Whether the device of that description can be opened and passes the probe, compiled on its own with the lanes that fit it.
[[nodiscard]] bool passes_canary(const DeviceInfo& info);

}  // namespace eikon
