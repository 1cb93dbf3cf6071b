// SPDX-License-Identifier: Apache-2.0
// The numbers of a render: what all devices did together, and for each device what it did, where
// its time went and what became of it. All times are seconds; points in time are host_seconds().
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "device/device.h"
#include "wavefront/layout/choose_layout.h"
#include "wavefront/tallies.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// Totals over the units that are in the film.
struct RenderTotals {
  std::uint64_t samples = 0;  // finished, rejected ones included
  double first_sample_s = 0;  // when the first unit was in the film
  double render_s = 0;        // duration of rendering, without the time between rounds
  RayCounts rays;
  // Rays that ended their search for an implicit surface after too many steps, and passed through.
  std::uint64_t search_failures = 0;
  // The surfaces of these rays. Bit i stands for Scene::shapes[i], and bit 31 for shapes[31] and
  // all behind it.
  std::uint32_t search_failure_surfaces = 0;
  std::uint64_t nonfinite = 0, saturated = 0;  // as UnitResult has them
  std::vector<PixelSample> rejected;           // the first few samples that were left out of the film
};

/// Tells what one device did in a render.
struct DeviceReport {
  DeviceInfo info;
  WavefrontConfig config;
  LayoutChoice layout;  // with the reason
  ArithmeticClass arithmetic;
  std::uint64_t samples = 0, units = 0;  // of those that are in the film
  std::uint64_t device_bytes = 0;        // memory of its buffers
  RayCounts rays;
  // Rays of speculative copies (schedule.h) that another device was faster with. `rays` and
  // `samples` leave them out; stages, bounces and times include them.
  RayCounts repeated_rays;
  double open_s = 0, compile_s = 0, upload_s = 0;  // over all times that it was opened
  double busy_s = 0;  // from its first unit to its last, without the time between rounds
  double wait_s = 0;  // without a unit, while other devices had work
  // Samples per second by the last measurement; 0: unknown.
  double rate = 0;
  double begin_s = 0;  // its first unit began
  double end_s = 0;    // its last unit was finished
  // Bytes that were copied before the first unit. A CPU device reads some buffers in place.
  std::uint64_t upload_bytes = 0;
  std::uint64_t failures = 0;                 // units that it lost
  std::map<std::string, StageTotals> stages;  // from the first unit on
  StageTotals gaps;                           // of the queue, between two commands
  Bounces bounces{};
  std::string error;  // the reason why it took no part, or stopped; empty: none
};

/// Something about a device that was not as it should be.
struct DeviceEvent {
  enum class Kind {
    failed,    // it lost its units and is tried again with smaller ones
    dropped,   // it failed for good, or could not be opened
    hung,      // a call did not return
    late,      // all work was done before it had finished, or was ready
    left_out,  // it got no more units because they would have been late
  };
  double at_s = 0;
  std::size_t device = 0;  // index into RenderReport::devices
  Kind kind = Kind::failed;
  std::string text;  // one line, without the device's name
};
[[nodiscard]] inline const char* name_of(DeviceEvent::Kind kind) {
  return std::array{"failed", "dropped", "hung", "late", "left_out"}.at(std::size_t(kind));
}

}  // namespace eikon
