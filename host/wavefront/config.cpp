// SPDX-License-Identifier: Apache-2.0
#include "wavefront/config.h"

#include <algorithm>
#include <bit>
#include <fmt/format.h>

#include "core/error.h"
#include "device/kernel_sources.h"
#include "wavefront/unit_shrink.h"

namespace eikon {

namespace {

constexpr std::uint64_t kPathBytes = 256;  // rough size of state and film slots of a path with all features
// Kernels of several lanes number the paths of a unit exactly below this
// (kernels/stages/path_state.h).
constexpr std::uint32_t kMaxExactPaths = 1U << 23;
// A device that launches each stage has a fixed cost for each depth of a unit, whatever the unit's
// size. An H200 takes 0.09 to 0.16 ms for each of the 25 to 80 depths of a unit that have less than
// 2^16 paths: with units of 2^23 paths 15 % of the time in cornell.gltf and 36 % in
// cornell_spheres.gltf (tools/gpu/MODEL.md).
constexpr std::uint32_t kMinQueuedCapacity = 1U << 20;
constexpr std::uint64_t kResident = 2048, kRoundsOfItems = 128;  // work-items that a compute unit holds; rounds of them
// A unit has at most capacity / kSamplesToFill pixels (on CPUs kSamplesToFillCores), because the
// sums of each pixel take memory. So a unit reaches the capacity only with so many samples of each
// pixel. On CPUs it does with the samples of a short pass (kMinSamples in render/schedule.cpp),
// because cores that have few paths each are idle for long.
constexpr std::uint32_t kSamplesToFill = 32, kSamplesToFillCores = 16;
// Measured on cores with 1 MiB of level-2 cache: chunks of 4096 paths (0.5 MiB of state) are 3 to 4
// % faster than chunks of 1024, because fewer of them end with empty lanes and rows of rays. 8192
// gain nothing more. With a launch per stage 1024 is best.
constexpr std::uint32_t kFusedChunk = 4096, kUnfusedChunk = 1024;
// So many that waiting for the last one costs next to nothing. With two work-items, units of
// 131,072 paths for each render cornell.gltf at 11.5 million samples per second, and units of
// 16,384 and 4,096 at 8.5 and 6.6: a launch takes a tenth of a millisecond, and the last portions
// of paths are small and leave lanes empty.
constexpr std::uint32_t kChunksPerWorker = 32;

/// Most paths of a unit that is not limited by memory.
std::uint64_t usual_capacity(const WavefrontConfig& config, const DeviceInfo& device, std::uint32_t chunk) {
  if (!config.chunked)
    return std::clamp(std::bit_floor(kRoundsOfItems * kResident * device.compute_units),
                      std::uint64_t{kMinQueuedCapacity}, std::uint64_t{kMaxUnitPaths});
  std::uint64_t paths = 1U << 18;
  while (config.fused && paths < kMaxExactPaths && paths / chunk < kChunksPerWorker * config.workers) paths *= 2;
  return paths;
}

}  // namespace

std::uint64_t available_bytes(const DeviceInfo& device, const Execution& execution) {
  return execution.memory_bytes == 0 ? device.memory_bytes : std::min(execution.memory_bytes, device.memory_bytes);
}

WavefrontConfig configure(const DeviceInfo& device, const Execution& execution) {
  WavefrontConfig config;
  config.chunked = execution.chunked.value_or(device.cpu);
  config.lanes = execution.lanes.value_or(!config.chunked ? 1 : device.native_float_lanes >= 16 ? 16 : 8);
  if (!config.chunked) config.lanes = 1;
  config.fused = config.chunked && execution.fused.value_or(true);
  config.workers = config.fused ? std::max(device.compute_units, 1U) : 1;
  const std::string own = own_layout(execution.accel);
  config.sum_buffers = device.cpu ? 1 : 2;
  config.layout = !own.empty()                ? own
                  : !execution.layout.empty() ? execution.layout
                  : config.chunked            ? (config.lanes == 16 ? "bvh16" : "bvh8")
                                              : "bvh2";
  std::uint32_t chunk = execution.chunk != 0 ? execution.chunk : config.fused ? kFusedChunk : kUnfusedChunk;
  if (execution.chunk == 0 && execution.unit_paths != 0) chunk = std::min(chunk, execution.unit_paths);
  chunk = std::max(chunk / 16, 1U) * 16;
  std::uint64_t paths = execution.unit_paths != 0 ? execution.unit_paths : usual_capacity(config, device, chunk);
  const std::uint64_t memory = available_bytes(device, execution);
  while (execution.unit_paths == 0 && paths > kMinUnitPaths && paths * kPathBytes > memory / 4) paths /= 2;
  if (config.chunked) paths = std::min<std::uint64_t>(paths, kMaxExactPaths);
  const auto whole = [&](std::uint32_t grain) { return std::max(std::uint32_t(paths) / grain, 1U); };
  config.chunk = config.chunked ? chunk : whole(kWorkGroup) * kWorkGroup;
  config.chunks = config.chunked ? whole(config.chunk) : 1;
  config.workers = std::min(config.workers, config.chunks);
  const std::uint32_t most_pixels =
      std::max(kBlockPixels, config.capacity() / (config.chunked ? kSamplesToFillCores : kSamplesToFill));
  config.pixels = std::min(config.capacity(), std::max(most_pixels, execution.block * execution.block));
  return config;
}

std::vector<std::string> class_stages(const WavefrontConfig& config, const Features& features) {
  std::vector<std::string> stages(SHADING_CLASS_COUNT);
  if (features.has(Feature::flat_lambert_hits)) stages.at(SHADING_FLAT_LAMBERT) = "shade_flat_lambert";
  if (features.has(Feature::opaque_hits)) stages.at(SHADING_OPAQUE) = "shade_opaque";
  if (features.has(Feature::transmissive_hits)) stages.at(SHADING_TRANSMISSIVE) = "shade_transmissive";
  const bool several = std::ranges::count(stages, "") < std::ptrdiff_t{SHADING_CLASS_COUNT} - 1;
  return !config.chunked && several ? stages : std::vector<std::string>{};
}

std::uint32_t hit_queue_count(const WavefrontConfig& config, const Features& features) {
  const std::vector<std::string> stages = class_stages(config, features);
  return std::uint32_t(std::ranges::count_if(stages, [](const std::string& stage) { return !stage.empty(); }));
}

bool needs_stage(const WavefrontConfig& config, const Features& features, const std::string& stage) {
  const bool of_lights = stage.starts_with("light_") || stage == "splat";
  if (of_lights && !features.has(Feature::light_paths)) return false;
  if (config.fused) return stage == "paths" || stage == "light_paths" || stage == "film";
  if (of_lights) return stage != "light_paths";
  if (stage == "miss") return features.has_environment();
  if (stage == "shadow") return features.has(Feature::next_event);
  const std::vector<std::string> by_class = class_stages(config, features);
  if (stage == "shade") return by_class.empty();
  if (stage == "sort_hits") return !by_class.empty();
  if (stage.starts_with("shade_")) return std::ranges::find(by_class, stage) != by_class.end();
  if (stage == "compact" || stage == "pack_sums") return !config.chunked;
  return stage != "paths";
}

ProgramOptions program_options(const DeviceInfo& device, const WavefrontConfig& config, const Features& features,
                               const Accel& accel, const Execution& execution) {
  ProgramOptions options;
  options.optimise = execution.optimise;
  options.extra_flags = execution.extra_flags;
  options.defines = features.defines();
  options.defines["EK_WIDTH"] = std::to_string(config.lanes);
  options.defines["EK_CHUNKED"] = config.chunked ? "1" : "0";
  options.defines["EK_CHUNK"] = std::to_string(config.chunk);
#if defined(__x86_64__) || defined(__aarch64__)
  if (device.cycle_counter && execution.ticks) options.defines["EK_TICKS"] = "1";  // ticks.h
#endif
  // Other drivers of processors, such as Mesa's, may hand programs on as SPIR-V, which has not all
  // that Clang has built in: its translator does not refuse a prefetch, but ends the process.
  if (device.cpu && !device.cycle_counter) options.defines["EK_PORTABLE"] = "1";  // lanes.h
  options.defines.merge(accel.defines());
  return options;
}

const Accel& accel_of(const PackedScene& scene, const WavefrontConfig& config) {
  const auto found = scene.accels.find(config.layout);
  if (found == scene.accels.end()) throw InternalError(fmt::format("no tree of layout '{}' was built", config.layout));
  return found->second;
}

WavefrontProgram::WavefrontProgram(const DeviceInfo& info, const WavefrontConfig& config, const PackedScene& scene,
                                   const Features& features, const Execution& execution)
    : formula_code(features.formula_code()),
      options(program_options(info, config, features, accel_of(scene, config), execution)) {
  std::vector<std::string> files;
#define EK_STAGE(name) \
  if (needs_stage(config, features, #name)) stages.push_back(#name), files.push_back("stages/" #name ".cl");
#define EK_CLASS_STAGE(name) \
  if (needs_stage(config, features, #name)) stages.push_back(#name), files.push_back("stages/by_class/" #name ".cl");
#include "shared/stages.def"
  files.push_back("probe/probes.cl");
  text = kernel_text(files) + formula_code;
}

}  // namespace eikon
