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
// What is named twice is there once, and so is hardware that several platforms show, unless it is asked for by name or index. A device cannot be there whole and in parts, or in overlapping parts.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/host_limits.h"
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

/// Whether two devices are one piece of hardware under two platforms: all CPU devices are this machine's processor; others have the
/// same PCI address or UUID, or, where one of them has neither of these in common, the same vendor and names of which one
/// holds the other.
[[nodiscard]] bool same_hardware(const DeviceInfo& a, const DeviceInfo& b);

struct Selection {
  std::vector<DeviceInfo> devices;
  std::vector<std::string> notes;  // a line each, for the user
};

/// The devices of `all` that `selection` names, in its order; position is set. Of one piece of hardware, `all`, `cpu` and
/// `gpu` take one device: of those that are trusted, the first that promises exact arithmetic, else the first; by name or index all
/// can be had.
/// trusted: asked only where several are to choose from
/// throws UsageError for what does not parse, or overlaps; DeviceError for what is not there, or cannot be had
[[nodiscard]] Selection resolve_selection(
    const std::string& selection, const std::vector<DeviceInfo>& all,
    const std::function<bool(const DeviceInfo&)>& trusted = [](const DeviceInfo&) { return true; });

/// Leaves a core for each thread that feeds another device than a CPU: those threads wait for their devices most of the time, in some
/// drivers without sleeping, and where a CPU device has all cores they get theirs too late. Parts that were asked for stay as they are.
/// host_threads: that the process may use. returns what to say about it, a line for each device that has less now
std::vector<std::string> leave_cores_to_feeders(std::vector<DeviceInfo>& chosen, unsigned host_threads);

/// Takes what a CPU device has beyond what the process may use. threads: 0, or at most so many compute units
void hold_to_limits(DeviceInfo& info, const HostLimits& host, unsigned threads);

}  // namespace eikon
