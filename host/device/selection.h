// SPDX-License-Identifier: Apache-2.0
// Parses --devices and chooses devices. The flag takes a list, separated by commas, of
//
//   all           every usable device
//   cpu, gpu      all devices of that kind
//   0             the device of that index in `eikon devices`
//   haswell       all devices whose names contain it
//   cpu:2x1       two sub-devices of one compute unit each, instead of the device
//   0:2x1+1x4     two sub-devices of one compute unit and one of four
//   0:2x1/2       the second of the sub-devices that 0:2x1 makes
//
// A device that is named twice is chosen once. Hardware that several platforms show is chosen once,
// unless it is named by name or index. A device cannot be chosen both whole and in parts, nor in
// overlapping parts.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/host_limits.h"
#include "device/device.h"

namespace eikon {

struct SelectionEntry {
  std::string text;                  // the whole entry
  std::string device;                // the entry before the parts, in lower case
  std::vector<std::uint32_t> parts;  // compute units of each sub-device; empty: the whole device
  std::uint32_t only = 0;            // number of the only part that is wanted, from 1; 0: all
};

/// throws UsageError that names the entry that does not parse
[[nodiscard]] std::vector<SelectionEntry> parse_selection(const std::string& selection);

/// Returns whether two devices are one piece of hardware under two platforms. All CPU devices are
/// this machine's processor. Other devices are the same if PCI address or UUID agree or, when they
/// have neither in common, if the vendor agrees and one name contains the other.
[[nodiscard]] bool same_hardware(const DeviceInfo& a, const DeviceInfo& b);

struct Selection {
  std::vector<DeviceInfo> devices;
  std::vector<std::string> notes;  // one line each, for the user
};

/// Returns the devices of `all` that `selection` names, in its order, with `position` set. For each
/// piece of hardware, `all`, `cpu` and `gpu` take one device: the first trusted one that promises
/// exact arithmetic, else the first trusted one. Names and indices choose any device.
/// trusted: called only where there are several devices to choose from
/// throws UsageError for entries that do not parse or overlap; DeviceError for devices that do not
/// exist or cannot be used
[[nodiscard]] Selection resolve_selection(
    const std::string& selection, const std::vector<DeviceInfo>& all,
    const std::function<bool(const DeviceInfo&)>& trusted = [](const DeviceInfo&) { return true; });

/// Leaves a core for each thread that feeds a device other than a CPU. These threads wait for their
/// devices most of the time, in some drivers without sleeping, and would get a core too late if a
/// CPU device had all of them. Parts that the user asked for stay as they are.
/// host_threads: threads that the process may use
/// returns  a note for each device that has fewer compute units now
std::vector<std::string> leave_cores_to_feeders(std::vector<DeviceInfo>& chosen, unsigned host_threads);

/// Reduces CPU devices to the compute units that the process may use, and to `threads` unless that
/// is 0.
void hold_to_limits(DeviceInfo& info, const HostLimits& host, unsigned threads);

}  // namespace eikon
