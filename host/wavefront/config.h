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

/// a / b, rounded up.
[[nodiscard]] inline std::uint32_t divide_up(std::uint64_t a, std::uint64_t b) {
  return std::uint32_t((a + b - 1) / b);
}

/// The way in which one device runs the stages, defaults filled in. A CPU device takes the paths of
/// a unit in chunks: one work-item runs a stage over all paths of a chunk, some lanes at a time. A
/// GPU has one work-item for each path.
struct WavefrontConfig {
  std::uint32_t lanes = 1;     // paths that one work-item traces in step: 1, 8 or 16
  bool chunked = false;        // false: as for GPUs, and all paths of a unit form one chunk
  bool fused = false;          // one launch per unit runs all stages (kernels/stages/paths.cl); only if chunked
  std::uint32_t workers = 1;   // work-items of that launch
  std::uint32_t chunk = 1024;  // paths of a chunk
  std::uint32_t chunks = 1;    // of a unit
  std::uint32_t pixels = 1;    // of a unit, at most
  std::uint32_t sum_buffers =
      1;  // 2: a device that reads sums back beside its work writes the next ones at the same time
  std::string layout = "bvh2";
  /// The most paths of a unit.
  [[nodiscard]] std::uint32_t capacity() const { return chunk * chunks; }
  /// Chunks whose state is in memory at the same time.
  [[nodiscard]] std::uint32_t held_chunks() const { return fused ? workers : chunks; }
};
/// The side of the smallest blocks of pixels that an image is cut into, and the pixels of one.
inline constexpr std::uint32_t kBlockSide = 128, kBlockPixels = kBlockSide * kBlockSide;
/// The bytes that a render may take of a device: its memory, or less by --memory.
[[nodiscard]] std::uint64_t available_bytes(const DeviceInfo& device, const Execution& execution);
/// Fills in by the device what `execution` leaves open. The most paths of a unit follow from the
/// device and its memory, and not from the scene.
WavefrontConfig configure(const DeviceInfo& device, const Execution& execution);
/// The stages that shade hits, each those of one shading class, where the device has a queue for
/// each class of the scene (kernels/stages/by_class/hit_queues.h); none if stage `shade` takes all.
/// In the order of the classes' numbers, the names of classes that the scene lacks left empty.
std::vector<std::string> class_stages(const WavefrontConfig& config, const Features& features);
/// The number of those stages, each of which has a queue.
std::uint32_t hit_queue_count(const WavefrontConfig& config, const Features& features);
/// True if a scene's program has that stage (stages.def) with this configuration.
bool needs_stage(const WavefrontConfig& config, const Features& features, const std::string& stage);
/// The options that the program is compiled with. accel: the tree that rays are traced through
ProgramOptions program_options(const DeviceInfo& device, const WavefrontConfig& config, const Features& features,
                               const Accel& accel, const Execution& execution);

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
