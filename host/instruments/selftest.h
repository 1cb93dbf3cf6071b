// SPDX-License-Identifier: Apache-2.0
// Is this driver to be trusted? Probes and scenes with known answers, on one device.
#pragma once
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/settings.h"

namespace eikon {

struct Check {
  std::string name;
  bool passed = false;
  std::string detail;  // what was found, against what
};

/// Record layout, arithmetic at each width, the furnace, an irradiance in closed form, and the same bits from wide and
/// narrow kernels. A check that throws has failed with the error's text; nothing escapes.
std::vector<Check> selftest(const DeviceInfo& device, const Execution& execution);

}  // namespace eikon
