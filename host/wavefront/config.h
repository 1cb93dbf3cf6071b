// SPDX-License-Identifier: Apache-2.0
// Decides how a device runs the stages from plain facts about it. The device is not touched.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "accel/accel.h"
#include "device/device.h"
#include "pack/features.h"
#include "pack/pack.h"
#include "pack/settings.h"

namespace eikon {

inline constexpr std::uint32_t kWorkGroup = EK_WORK_GROUP;  // work-items of a work-group on GPU devices

/// How one device runs the stages, defaults filled in.
struct WavefrontConfig {
  std::uint32_t lanes = 1;
  bool chunked = false;
  bool fused = false;          // one launch per unit: kernels/stages/paths.cl
  std::uint32_t workers = 1;   // work-items of that launch
  std::uint32_t chunk = 1024;  // slots per chunk; the whole pool when not chunked
  std::uint32_t chunks = 1;    // of a unit
  std::string layout = "bvh2";
  /// The most paths of a unit.
  [[nodiscard]] std::uint32_t capacity() const { return chunk * chunks; }
  /// Chunks whose state is in memory at the same time.
  [[nodiscard]] std::uint32_t held_chunks() const { return fused ? workers : chunks; }
};
WavefrontConfig configure(const DeviceInfo& device, const Execution& execution);
/// True if a scene's program has that stage (stages.def) with this configuration.
bool needs_stage(const WavefrontConfig& config, const Features& features, const std::string& stage);
/// The options that the program is compiled with. accel: the tree that rays are traced through
ProgramOptions program_options(const DeviceInfo& device, const WavefrontConfig& config, const Features& features,
                               const Accel& accel, const Execution& execution);
/// Device memory for the state, film slots and logs of all paths in flight.
std::uint64_t path_pool_bytes(const WavefrontConfig& config, const Features& features);

/// The tree that a device traces rays through. throws InternalError if no tree of its layout was
/// built
const Accel& accel_of(const PackedScene& scene, const WavefrontConfig& config);

/// The source of one device's program. Text and options alone decide its machine code.
struct WavefrontProgram {
  std::vector<std::string> stages;  // kernels of stages.def that the scene needs, run as configured
  std::string text;
  std::string formula_code;  // the part of the text that evaluates the scene's implicit surfaces
  ProgramOptions options;

  [[nodiscard]] bool has(const std::string& stage) const { return std::ranges::find(stages, stage) != stages.end(); }
  WavefrontProgram(const DeviceInfo& info, const WavefrontConfig& config, const PackedScene& scene,
                   const Features& features, const Execution& execution);
};

}  // namespace eikon
