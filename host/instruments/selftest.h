// SPDX-License-Identifier: Apache-2.0
// Tests whether a driver can be trusted: probes and scenes with known answers, on one device.
#pragma once
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/settings.h"

namespace eikon {

struct Check {
  std::string name;
  bool passed = false;
  std::string detail;  // the result and the expected value
};

/// Checks the layout of records, the arithmetic at each width, a furnace, an irradiance of closed
/// form, and that wide and narrow kernels give the same bits. A check that throws has failed with
/// the error's text; nothing is thrown to the caller.
std::vector<Check> selftest(const DeviceInfo& device, const Execution& execution);

}  // namespace eikon
