// SPDX-License-Identifier: Apache-2.0
// How a device runs the stages: decisions from plain facts about it, without touching it.
#pragma once
#include <cstdint>
#include <string>

#include "accel/accel.h"
#include "device/device.h"
#include "pack/features.h"
#include "pack/settings.h"

namespace eikon {

/// How one device runs the stages, after defaults by device.
struct WavefrontConfig {
  std::uint32_t lanes = 1;
  bool chunked = false;
  bool fused = false;          // one launch per unit: kernels/stages/paths.cl
  std::uint32_t workers = 1;   // work-items of that launch
  std::uint32_t chunk = 1024;  // slots per chunk; the whole pool when not chunked
  std::uint32_t chunks = 1;    // of a unit
  std::string layout = "bvh2";
  /// Paths of a unit, at most.
  [[nodiscard]] std::uint32_t capacity() const { return chunk * chunks; }
  /// Chunks whose state is in memory at once.
  [[nodiscard]] std::uint32_t held_chunks() const { return fused ? workers : chunks; }
};
WavefrontConfig configure(const DeviceInfo& device, const Execution& execution);
/// Whether a scene's program has that stage (stages.def), run like this.
bool needs_stage(const WavefrontConfig& config, const Features& features, const std::string& stage);
/// What that program is compiled with. accel: the tree that its rays meet
ProgramOptions program_options(const DeviceInfo& device, const WavefrontConfig& config, const Features& features,
                               const Accel& accel, const Execution& execution);
/// Device memory for the state and film slots of all paths in flight.
std::uint64_t path_pool_bytes(const WavefrontConfig& config, const Features& features);

}  // namespace eikon
