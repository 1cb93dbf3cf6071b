// SPDX-License-Identifier: Apache-2.0
// What --devices takes: a list, separated by commas, of
//
//   all           every device that can be used
//   cpu, gpu      all of that kind
//   0             the device of that index in `eikon devices`
//   haswell       all devices with that in their names
//   cpu:2x1       instead of the device, two sub-devices of one compute unit each: devices like others, each with its own queue
//   0:2x1+1x4     two sub-devices of one compute unit and one of four
//   0:2x1/2       the second of those that 0:2x1 makes
//
// What is named twice is there once. A device cannot be there whole and in parts, or in overlapping parts.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "device/device.h"

namespace eikon {

struct SelectionEntry {
  std::string text;                  // all of it
  std::string device;                // before the parts, in lower case
  std::vector<std::uint32_t> parts;  // compute units of each sub-device; empty: the device as it is
  std::uint32_t only = 0;            // from 1: just this part
};

/// throws UsageError with the entry that does not parse
[[nodiscard]] std::vector<SelectionEntry> parse_selection(const std::string& selection);

/// The devices of `all` that `selection` names, in its order; position is set.
/// throws UsageError for what does not parse, or overlaps; DeviceError for what is not there, or cannot be had
[[nodiscard]] std::vector<DeviceInfo> resolve_selection(const std::string& selection,
                                                        const std::vector<DeviceInfo>& all);

}  // namespace eikon
