// SPDX-License-Identifier: Apache-2.0
// Launches the depths of a unit, stage by stage, and reads how many paths they leave.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "device/device.h"
#include "shared/records.h"
#include "wavefront/config.h"
#include "wavefront/ray_counters.h"
#include "wavefront/stages/depth_plan.h"
#include "wavefront/stages/stage_kernels.h"
#include "wavefront/transfer_words.h"

namespace eikon {

class DepthStages {
 public:
  /// All of them must outlive this, and stay where they are.
  DepthStages(Device& device, const WavefrontConfig& config, StageKernels& stages, RayCounters& counters)
      : device_(device), config_(config), stages_(stages), counters_(counters) {}

  /// Launches the first depth of a unit.
  /// counts  the buffer of that name
  void begin(const Frame& frame, const Buffer& counts);
  /// Launches the depths behind it, until none has a path. The host looks at the counts of a depth
  /// while the next one is under way.
  /// returns  the rays that were scattered, and the shadow rays
  RayCounts launch_rest();
  /// Waits for reads that are still under way. To be called after launch_rest() and before the
  /// memory of this goes.
  void settle();

  /// While this is set, the host waits for each depth before it launches the next, and calls
  /// after_intersect between two stages.
  bool replays_one_path = false;
  std::function<void(std::uint32_t depth)> after_intersect;

 private:
  /// The counts that some depths left in the queues, being read back.
  struct ReadBack {
    std::uint32_t first = 0, last = 0;  // depths
    TransferWords counts;               // words of buffer `counts`
    Ticket ticket;                      // they are there
  };

  Device& device_;
  const WavefrontConfig& config_;
  StageKernels& stages_;
  RayCounters& counters_;
  Buffer counts_;
  DepthPlan plan_;
  std::deque<ReadBack> read_backs_;   // they must outlive their transfers
  std::vector<TransferWords> spare_;  // for the next ones
  // These belong to the unit that is under way.
  std::uint64_t paths_ = 0;
  std::uint32_t max_depth_ = 0;
  std::uint32_t launched_ = 0;  // depths
  std::uint64_t left_ = 0;      // paths of the last depth for which that is known,
  std::uint32_t known_ = 0;     // and that depth

  void launch(std::uint32_t count);
  RayCounts take_first();
  [[nodiscard]] std::uint32_t next_depths() const;
};

}  // namespace eikon
