// SPDX-License-Identifier: Apache-2.0
// Counts the rays that a wavefront traced, for the profiler's stages, the table of bounces, and the
// trace.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/trace.h"
#include "device/device.h"
#include "wavefront/config.h"
#include "wavefront/tallies.h"

namespace eikon {

/// Numbers of rays of each kind.
struct RayCounts {
  std::uint64_t camera = 0, scattered = 0, shadow = 0;
  [[nodiscard]] std::uint64_t total() const { return camera + scattered + shadow; }
  RayCounts& operator+=(const RayCounts& more) {
    camera += more.camera, scattered += more.scattered, shadow += more.shadow;
    return *this;
  }
};

class RayCounters {
 public:
  /// timeline: nullptr if nothing is recorded. Device and timeline must outlive this.
  RayCounters(Device& device, const WavefrontConfig& config, const Features& features, Trace* timeline);
  /// Starts again from 0.
  void restart(Trace* timeline);
  /// The counts of all units so far.
  [[nodiscard]] const Bounces& bounces() const { return bounces_; }

  /// Adds a unit that was rendered in one launch.
  /// tallies  counts of its work-items
  /// shares   of the stages in the launch's time (tallies.h)
  /// returns  the rays of the unit
  RayCounts add_launch(std::uint64_t paths, std::span<const WorkerTally> tallies,
                       const std::map<std::string, double>& shares);

  // A unit with a launch for each stage is added by begin_unit(), then add_depth() and end_depth()
  // for each depth.

  void begin_unit(std::uint64_t paths);
  /// A depth is launched. work_items: of a stage; they count if stages take paths from queues
  void add_depth(std::uint32_t depth, std::uint64_t work_items);
  /// A depth is over.
  /// counts   for queue_counts(), of all chunks of the unit
  /// paths    of the unit
  /// returns  the rays that were scattered, and the shadow rays
  RayCounts end_depth(std::uint32_t depth, std::span<const std::uint32_t> counts, std::uint64_t paths);
  /// Adds the hits of a depth by shading class, if each class has a stage of its own.
  void add_class_hits(std::span<const std::uint32_t> hits);

 private:
  void count_paths(std::uint32_t depth, std::uint64_t paths);
  void count_live(double paths);

  Device& device_;
  WavefrontConfig config_;
  bool has_environment_, has_shadow_;
  std::vector<std::string> class_stages_;
  Trace* timeline_;
  std::string live_counter_;  // name of the counter in the trace
  double counted_s_ = 0;      // time of its last value
  Bounces bounces_{};
};

}  // namespace eikon
