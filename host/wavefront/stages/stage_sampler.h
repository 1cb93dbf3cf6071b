// SPDX-License-Identifier: Apache-2.0
// Estimates the stages' shares of a launch that runs all of them, on processors without a counter
// that a program may read.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "device/device.h"
#include "shared/records.h"
#include "wavefront/config.h"
#include "wavefront/stages/stage_kernels.h"

namespace eikon {

/// Now and then runs a small part of a unit with a launch per stage, besides the launch that
/// renders it, and measures the stages' shares. This takes less than 1/32 of the first unit's time,
/// and 1/256 of the time of all later ones.
class StageSampler {
 public:
  /// Compiles. stages: of `program`, in the order of a bounce, `generate` first; arguments: of the
  /// fused kernels
  /// throws DeviceError
  StageSampler(Device& device, const Program& program, const std::vector<std::string>& stages,
               const Arguments& arguments, const WavefrontConfig& config);
  /// Binds the kernels, to be called again when a buffer in `arguments` is another one.
  void bind(const Arguments& arguments);
  /// Takes a sample if it is time for one, and blocks then. Call it before a unit is launched,
  /// because it overwrites state and film slots. frame, pixels: of the unit. throws DeviceError
  void before(const Frame& frame, std::span<const std::uint32_t> pixels);
  /// The stages' shares of a launch; their sum is 1. Empty before the first sample.
  [[nodiscard]] const std::map<std::string, double>& shares() const { return shares_; }

  /// Chooses the pixels of a sample: runs of 16 neighbours from all over the unit. count: at most
  /// pixels.size()
  static std::vector<std::uint32_t> choose_pixels(std::span<const std::uint32_t> pixels, std::size_t count);

 private:
  void run(std::uint32_t path_count);

  Device& device_;
  WavefrontConfig config_;
  std::vector<std::string> stages_;
  StageKernels kernels_;
  Buffer frame_, pixels_, counts_;
  std::uint64_t sampled_ = 0, rendered_ = 0;  // paths
  std::map<std::string, double> seconds_, shares_;
};

}  // namespace eikon
