// SPDX-License-Identifier: Apache-2.0
// Probes of a device: of its arithmetic, since devices of one class give the same image bits, and
// of whether it reads what lies in its memory. Every device is probed before a render trusts it,
// which takes about a millisecond.
#pragma once
#include <cstdint>
#include <string>

#include "core/error.h"
#include "device/device.h"

namespace eikon {

/// The class of a device's arithmetic, which is a hash of the probe's results.
struct ArithmeticClass {
  std::uint32_t hash = 0;
  // IEEE single precision, uncontracted: the class of every conforming device.
  [[nodiscard]] bool exact() const;
  [[nodiscard]] std::string name() const;  // "exact", or "other-1a2b3c4d"
  bool operator==(const ArithmeticClass&) const = default;
};

/// Runs kernel `probes` of `program`: the probes of arithmetic and memory before a render trusts a
/// device.
/// throws UntrustedDevice when the driver reads memory wrongly, DeviceError
ArithmeticClass trusted_arithmetic(Device& device, const Program& program);
/// Compiles and runs the probe of arithmetic alone, `lanes` wide. throws DeviceError
ArithmeticClass probe_arithmetic(Device& device, std::uint32_t lanes, bool optimise = true);

/// Compares sizes and offsets of records with the host's.
/// throws InternalError with the name of the first that differs
void check_record_layout(Device& device, bool optimise = true);

/// The driver gives wrong results, so trying again is of no use.
struct UntrustedDevice : DeviceError {
  using DeviceError::DeviceError;
};

/// Runs kernel `canary` of `program`. throws UntrustedDevice; DeviceError when it cannot run
void require_canary(Device& device, const Program& program);

/// Opens a device and runs the probe alone, with the lanes that fit the device.
/// returns  whether both succeeded
[[nodiscard]] bool passes_canary(const DeviceInfo& info);

}  // namespace eikon
