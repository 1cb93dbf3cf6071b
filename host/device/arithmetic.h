// SPDX-License-Identifier: Apache-2.0
// Is a device's arithmetic the one that gives everybody's bits?
#pragma once
#include <cstdint>
#include <string>

#include "device/device.h"

namespace eikon {

/// The class of a device's arithmetic: a hash over the probe's results. Devices of one class give the same image bits.
struct ArithmeticClass {
  std::uint32_t hash = 0;
  [[nodiscard]] bool exact() const;        // IEEE single precision, uncontracted: the class of every conforming device
  [[nodiscard]] std::string name() const;  // "exact", or "other-1a2b3c4d"
  bool operator==(const ArithmeticClass&) const = default;
};

/// Runs kernel `probes`, which `program` holds: what a device is asked before a render trusts it.
/// throws UntrustedDevice where its driver reads memory wrongly (device/canary.h), DeviceError
ArithmeticClass trusted_arithmetic(Device& device, const Program& program);
/// Runs the probe of arithmetic alone, compiled on its own, `lanes` wide. throws DeviceError
ArithmeticClass probe_arithmetic(Device& device, std::uint32_t lanes, bool optimise = true);

/// Compares record sizes and offsets with the host's. throws InternalError naming the first that differs.
void check_record_layout(Device& device, bool optimise = true);

}  // namespace eikon
