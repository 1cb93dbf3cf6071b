// SPDX-License-Identifier: Apache-2.0
// What a device did in a render, where its time went, and what became of it.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "device/device.h"
#include "wavefront/bounces.h"
#include "wavefront/layout/choose_layout.h"
#include "wavefront/wavefront.h"

namespace eikon {

struct DeviceReport {
  DeviceInfo info;
  WavefrontConfig config;
  LayoutChoice layout;  // and why
  ArithmeticClass arithmetic;
  std::uint64_t samples = 0, units = 0, device_bytes = 0;
  RayCounts rays;
  double open_s = 0, compile_s = 0, upload_s = 0;
  double busy_s = 0;                          // from its first unit to its last, without looks
  double wait_s = 0;                          // for a unit, while there was work that others had
  double rate = 0;                            // samples per second, as measured at last; 0: unknown
  double begin_s = 0;                         // its first unit began; host_seconds()
  double end_s = 0;                           // its last unit was in the film; host_seconds()
  std::uint64_t upload_bytes = 0;             // before the first unit; what a CPU device reads in place is not moved
  std::uint64_t failures = 0;                 // units that it lost
  std::map<std::string, StageTotals> stages;  // from the first unit on
  StageTotals gaps;                           // of the queue, between two commands
  Bounces bounces{};
  std::string error;  // why it took no part, or no longer; empty: nothing is wrong
};

/// Something about a device that was not as it should be.
struct DeviceEvent {
  enum class Kind {
    failed,    // it lost its units, and is tried again with smaller ones
    dropped,   // it failed for good, or could not be opened
    hung,      // a call did not come back
    late,      // all was done before it had finished, or was ready
    left_out,  // its units would have been late
  };
  double at_s = 0;         // host_seconds()
  std::size_t device = 0;  // index into RenderReport::devices
  Kind kind = Kind::failed;
  std::string text;  // one line, without the device's name
};
[[nodiscard]] const char* name_of(DeviceEvent::Kind kind);

}  // namespace eikon
