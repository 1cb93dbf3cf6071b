// SPDX-License-Identifier: Apache-2.0
// Launches stages that have a launch of their own.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "device/device.h"
#include "wavefront/config.h"
#include "wavefront/tallies.h"

namespace eikon {

/// Kernels of stages, each of which runs over the paths of one depth.
class StageKernels {
 public:
  StageKernels() = default;
  /// stages: names of stages.def, which `program` has. throws DeviceError
  StageKernels(Device& device, const WavefrontConfig& config, const Program& program, std::span<const std::string> stages);

  /// To be called again when a buffer in `arguments` is another one.
  void bind(const Arguments& arguments);
  /// Launches each stage over as few work-items as it can have. Some drivers make machine code only
  /// then.
  void warm_up();
  /// Launches a stage, if it is one of these: a work-item for each chunk of a unit, or without
  /// chunks one for each entry of the queue.
  /// paths   of the unit
  /// active  of them, that the queue holds at most
  void run(const std::string& stage, std::uint32_t depth, std::uint64_t paths, std::uint64_t active);
  /// The chunks that the paths of a unit lie in; 1 if there are no chunks.
  [[nodiscard]] std::size_t chunks(std::uint64_t paths) const;
  /// Waits for what a depth has left in the queues. counts: the buffer of that name; paths: of the
  /// unit
  [[nodiscard]] QueueCounts read_counts(const Buffer& counts, std::uint32_t depth, std::uint64_t paths);

 private:
  struct Stage {
    Kernel kernel;
    std::size_t group = 1;  // work-items of a work-group
  };

  Device* device_ = nullptr;
  WavefrontConfig config_;
  std::map<std::string, Stage> stages_;
};

}  // namespace eikon
