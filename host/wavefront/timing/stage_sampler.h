// SPDX-License-Identifier: Apache-2.0
// Where one launch runs all stages and the processor has no counter that a program may read: how the stages share that launch.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "device/device.h"
#include "wavefront/wavefront_config.h"
#include "shared/records.h"

namespace eikon {

/// Now and then runs a small part of a unit with a launch per stage, besides the launch that renders it, and takes the stages'
/// shares from that: less than a thirtieth of the first unit, and a two-hundredth of what comes.
class StageSampler {
 public:
  /// stages: in the order of a bounce, `generate` first; program: has them; arguments: of the fused kernels. Compiles.
  /// throws DeviceError
  StageSampler(Device& device, const Program& program, const std::vector<std::string>& stages,
               const Arguments& arguments, const WavefrontConfig& config);
  /// Before a unit is launched, whose state and film slots this uses up. Blocks if it is time for a sample.
  /// frame, pixels: of the unit. throws DeviceError
  void before(const Frame& frame, std::span<const std::uint32_t> pixels);
  /// Of a launch of all stages, as far as is known; together 1, or empty.
  [[nodiscard]] const std::map<std::string, double>& shares() const { return shares_; }

  /// The pixels of a sample: runs of 16, which are neighbours, from all over the unit. count: at most pixels.size()
  static std::vector<std::uint32_t> spread(std::span<const std::uint32_t> pixels, std::size_t count);

 private:
  void run(std::uint32_t path_count);

  Device& device_;
  WavefrontConfig config_;
  std::vector<std::pair<std::string, Kernel>> stages_;
  Buffer frame_, pixels_, counts_;
  std::uint64_t sampled_ = 0, rendered_ = 0;  // paths
  std::map<std::string, double> seconds_, shares_;
};

}  // namespace eikon
