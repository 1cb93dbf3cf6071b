// SPDX-License-Identifier: Apache-2.0
// How many rays a wavefront traced, told to whoever asks: the profiler's stages, the bounces' table and the trace.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "core/trace.h"
#include "device/device.h"
#include "wavefront/bounces.h"
#include "wavefront/wavefront_config.h"

namespace eikon {

/// Rays of each kind.
struct RayCounts {
  std::uint64_t camera = 0, scattered = 0, shadow = 0;
  [[nodiscard]] std::uint64_t total() const { return camera + scattered + shadow; }
  RayCounts& operator+=(const RayCounts& more) {
    camera += more.camera, scattered += more.scattered, shadow += more.shadow;
    return *this;
  }
};

class RayCensus {
 public:
  /// timeline: nullptr where nothing is recorded. Device and timeline must outlive it.
  RayCensus(Device& device, const WavefrontConfig& config, const Features& features, Trace* timeline);
  /// As new.
  void restart(Trace* timeline);
  /// Of all units so far.
  [[nodiscard]] const Bounces& bounces() const { return bounces_; }

  /// A unit that was rendered in one launch.
  /// tallies  of its work-items; shares  of the stages in the launch: see stage_shares.h. returns its rays
  RayCounts add_launch(std::uint64_t paths, std::span<const WorkerTally> tallies,
                       const std::map<std::string, double>& shares);

  // A unit with a launch for each stage: begin_unit(), then for each depth add_depth() and end_depth().

  void begin_unit(std::uint64_t paths);
  /// A depth is launched. work_items  of a stage; counts where they take paths from queues
  void add_depth(std::uint32_t depth, std::uint64_t work_items);
  /// A depth is over. counts  of each chunk, four words: paths for even depths and for odd ones, shadow rays, and one more
  /// paths  of the unit. returns the rays that go on, as scattered, and those that were cast at lights
  RayCounts end_depth(std::uint32_t depth, std::span<const std::uint32_t> counts, std::uint64_t paths);

 private:
  void count_paths(std::uint32_t depth, std::uint64_t paths);
  void count_live(double paths);

  Device& device_;
  WavefrontConfig config_;
  bool has_environment_, has_shadow_;
  Trace* timeline_;
  std::string live_counter_;  // its name there
  double counted_s_ = 0;      // up to when
  Bounces bounces_{};
};

}  // namespace eikon
