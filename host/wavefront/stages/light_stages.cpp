// SPDX-License-Identifier: Apache-2.0
#include "wavefront/stages/light_stages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>

#include "core/error.h"
#include "pack/frame.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxPaths = 1U << 16;   // of a part,
constexpr std::uint64_t kCapacityShare = 8;     // or this part of those that a device with queues traces at once
constexpr std::uint32_t kSplatsPerPath = 4;     // that there is room for; rooms with glass have .4 to 1.9
constexpr std::uint32_t kLikelySplatsPerPath = 2;
// Numbers of light paths that a part has, on devices with chunks. Each is traced for all samples of
// the part, so this bounds the paths of parts with fewer than eight samples.
constexpr std::uint64_t kMaxNumbers = 1U << 13;
constexpr float kRange = 0x1p54F;                 // of splats: 2^38 of radiance, and kSplatShift
static_assert(kSplatShift == 16);
constexpr std::uint32_t kNoneTaken = 0;
constexpr std::array<std::uint32_t, SPLATS_COUNTS> kNoSplats{};

std::uint64_t most_paths(const WavefrontConfig& config) {
  const std::uint64_t capacity = config.capacity();
  return std::min(capacity, config.chunked ? kMaxPaths : std::max(kMaxPaths, capacity / kCapacityShare));
}
std::uint32_t splat_capacity(const WavefrontConfig& config) {
  return kSplatsPerPath * std::uint32_t(most_paths(config)) + EK_PAD;
}

/// The numbers first to end - 1, counted through the ranges.
std::vector<std::uint32_t> numbers_of(std::span<const LightPathRange> ranges, std::uint64_t first, std::uint64_t end) {
  std::vector<std::uint32_t> numbers;
  std::uint64_t before = 0;
  for (const LightPathRange& range : ranges) {
    const std::uint64_t after = before + range.count;
    for (std::uint64_t at = std::max(before, first); at < std::min(after, end); ++at)
      numbers.push_back(range.first + std::uint32_t(at - before));
    before = after;
  }
  return numbers;
}

}  // namespace

LightUnit::Part take_light_part(std::vector<LightUnit::Part>& left, const WavefrontConfig& config) {
  LightUnit::Part part = left.back();
  left.pop_back();
  const std::uint64_t most = most_paths(config);
  // The numbers stand in the buffer for the pixels of a unit. A device that launches each stage
  // waits for each depth of a part, so it gets few large ones.
  const std::uint64_t most_numbers =
      config.chunked ? std::min<std::uint64_t>(kMaxNumbers, config.pixels) : config.pixels;
  const std::uint64_t samples = std::min(part.sample_end - part.sample_begin, most);
  const std::uint64_t numbers =
      std::min(part.end - part.first, std::clamp<std::uint64_t>(most / samples, 1, most_numbers));
  LightUnit::Part later = part, others = part;
  part.sample_end = later.sample_begin = part.sample_begin + samples;
  part.end = others.first = part.first + numbers;
  others.sample_end = part.sample_end;
  if (later.sample_begin < later.sample_end) left.push_back(later);
  if (others.first < others.end) left.push_back(others);
  return part;
}

std::vector<LightPathRange> light_paths_of(const LightPathPlan& plan, const Crop& block) {
  std::vector<LightPathRange> ranges;
  const std::uint64_t pixels = plan.window.pixel_count();
  for (std::uint32_t y = block.y0; y < block.y1; ++y) {
    const std::uint64_t row = std::uint64_t{y - plan.window.y0} * plan.window.width();
    const std::uint64_t first = (row + (block.x0 - plan.window.x0)) * plan.count / pixels;
    const std::uint64_t end = (row + (block.x1 - plan.window.x0)) * plan.count / pixels;
    if (first < end) ranges.push_back({std::uint32_t(first), std::uint32_t(end - first)});
  }
  return ranges;
}

std::uint64_t LightStages::bytes(const WavefrontConfig& config) {
  return (config.fused ? 2 : 1) * 4 * std::uint64_t{SPLAT_WORDS} * splat_capacity(config);
}

LightStages::LightStages(Device& device, const Program& program, const WavefrontConfig& config, Arguments& arguments)
    : device_(&device), config_(config) {
  for (std::size_t i = 0; i < splats_.size(); ++i) {
    const bool shares = !config.fused && i > 0;
    splats_[i] = shares ? splats_[0] : device.allocate(std::size_t{4} * SPLAT_WORDS * splat_capacity(config));
    counts_[i] = shares ? counts_[0] : device.allocate(sizeof kNoSplats);
    device.fill_zero(counts_[i]);
    if (config.fused) fused_[i] = program.kernel("light_paths");
  }
  arguments.set("splats", splats_[0]);
  arguments.set("splat_counts", counts_[0]);
}

void LightStages::bind(const Arguments& arguments, StageKernels& stages) {
  if (device_ == nullptr) return;
  stages_ = &stages;
  frame_ = arguments.buffers().at("frame");
  numbers_ = arguments.buffers().at("pixels");
  next_path_ = arguments.buffers().at("next_path");
  queue_counts_ = arguments.buffers().at("counts");
  for (std::size_t i = 0; config_.fused && i < fused_.size(); ++i) {
    Arguments own = arguments;
    own.set("splats", splats_[i]);
    own.set("splat_counts", counts_[i]);
    fused_[i].bind(own);
  }
}

void LightStages::begin(LightUnit& lights, std::size_t which, const WorkUnit& unit, const LightPathPlan& plan,
                        const Frame& frame) {
  lights.ranges = light_paths_of(plan, unit.block);
  lights.count = 0;
  for (const LightPathRange& range : lights.ranges) lights.count += range.count;
  lights.left.clear();
  if (lights.count > 0) lights.left.push_back({0, lights.count, unit.sample_begin, unit.sample_end});
  start(lights, which, EK_OF_LIGHT_PATHS, frame);
}

void LightStages::find_photons(LightUnit& lights, std::size_t which, std::pair<std::uint64_t, std::uint64_t> samples,
                               const Frame& frame) {
  lights.ranges = {{0, frame.light_path_count}};
  lights.count = frame.light_path_count;
  lights.left = {{0, lights.count, samples.first, samples.second}};
  lights.record_words = PHOTON_WORDS;
  lights.value_word = PHOTON_r;
  start(lights, which, EK_OF_PHOTONS, frame);
  finish(lights, which);
  lights.rays.shadow = 0;  // photons waited in their place
}

/// kind: EK_OF_*
void LightStages::start(LightUnit& lights, std::size_t which, std::uint32_t kind, const Frame& frame) {
  lights.splats.clear();
  lights.rays = {};
  lights.nonfinite = lights.saturated = 0;
  lights.frame = frame;
  lights.frame.of_light_paths = kind;
  lights.frame.splat_capacity = splat_capacity(config_) * SPLAT_WORDS / lights.record_words;
  if (lights.left.empty()) return;
  launch(lights, which);
  if (!config_.fused) finish(lights, which);
}

void LightStages::launch(LightUnit& lights, std::size_t which) {
  lights.running = take_light_part(lights.left, config_);
  lights.numbers = numbers_of(lights.ranges, lights.running.first, lights.running.end);
  const std::size_t count = lights.numbers.size();
  lights.frame = unit_frame(lights.frame, lights.running.sample_begin, lights.running.sample_end, std::uint32_t(count));
  device_->write_later(frame_, &lights.frame, sizeof lights.frame);
  device_->write_later(numbers_, lights.numbers.data(), 4 * count);
  device_->write_later(counts_[which], kNoSplats.data(), sizeof kNoSplats);
  if (config_.fused) {
    device_->write_later(next_path_, &kNoneTaken, sizeof kNoneTaken);
    device_->run(fused_[which], config_.workers, 1, lights.frame.path_count);
  } else {
    run_stages(lights);
  }
  // The number of splats is not known yet. So this read asks for as many as the paths are likely to
  // leave. collect() reads the rest, if there are more; that read then waits for all that is in the
  // device's queue. Where each stage has a launch of its own, the host has already waited for the
  // last launch, so collect() reads all of them and no more.
  const std::size_t likely =
      config_.fused ? std::min<std::size_t>(kLikelySplatsPerPath * lights.frame.path_count, lights.frame.splat_capacity)
                    : 0;
  lights.words.resize(likely * lights.record_words);
  if (likely > 0) device_->read_later(splats_[which], lights.words.data(), 4 * lights.words.size());
  lights.counted = device_->read_later(counts_[which], lights.counts.data(), sizeof lights.counts);
  device_->flush();
}

void LightStages::warm_up() {
  for (const Kernel& kernel : fused_)
    if (device_ != nullptr && config_.fused) device_->run(kernel, 1, 1);
}

void LightStages::run_stages(LightUnit& lights) {
  lights.part_rays = {};
  const std::uint64_t paths = lights.frame.path_count;
  stages_->run("light_generate", 1, paths, paths);
  std::uint64_t active = paths;
  for (std::uint32_t depth = 1; active > 0; ++depth) {
    for (const char* stage : {"intersect", "light_shade", "compact", "splat"})
      stages_->run(stage, depth, paths, active);
    const QueueCounts left = stages_->read_counts(queue_counts_, depth, paths);
    lights.part_rays.scattered += active;
    lights.part_rays.shadow += left.shadow_rays;
    active = left.next_paths;
  }
}

void LightStages::collect(LightUnit& lights, std::size_t which) {
  device_->wait(lights.counted);
  const std::uint32_t stored = lights.counts[SPLATS_stored];
  if (stored > lights.frame.splat_capacity) {
    // Halves of it are traced again. The rays of this attempt do not count: the trial of light
    // paths weighs the cost in rays, which must not depend on how many splats a device has room
    // for.
    LightUnit::Part first = lights.running, second = lights.running;
    if (first.end - first.first > 1)
      first.end = second.first = std::midpoint(first.first, first.end);
    else if (first.sample_end - first.sample_begin > 1)
      first.sample_end = second.sample_begin = std::midpoint(first.sample_begin, first.sample_end);
    else
      throw DeviceError(lights.frame.of_light_paths == EK_OF_PHOTONS
                            ? "a light path leaves more photons than there is memory for; leave --caustics merge out"
                            : "a light path leaves more splats than there is memory for; use --light-paths off");
    lights.left.push_back(second);
    lights.left.push_back(first);
    return;
  }
  lights.rays += lights.part_rays;
  lights.rays.scattered += lights.counts[SPLATS_path_rays];
  lights.rays.shadow += lights.counts[SPLATS_shadow_rays];
  std::vector<std::uint32_t>& words = lights.words;
  const std::size_t read = words.size();
  words.resize(std::size_t{stored} * lights.record_words);
  if (words.size() > read) device_->read(splats_[which], &words[read], 4 * (words.size() - read), 4 * read);
  std::size_t begin = 0;  // of the records since the last one that was left out
  const auto take_until = [&](std::size_t end) {
    lights.splats.insert(lights.splats.end(), words.begin() + std::ptrdiff_t(begin),
                         words.begin() + std::ptrdiff_t(end));
  };
  for (std::size_t at = 0; at < words.size(); at += lights.record_words) {
    bool finite = true, in_range = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = std::bit_cast<float>(words[at + lights.value_word + c]);
      finite = finite && std::isfinite(value);
      in_range = in_range && std::abs(value) < kRange;
    }
    if (finite && in_range) continue;
    ++(finite ? lights.saturated : lights.nonfinite);
    take_until(at);
    begin = at + lights.record_words;
  }
  take_until(words.size());
}

void LightStages::finish(LightUnit& lights, std::size_t which) {
  if (!lights.counted) return;
  collect(lights, which);
  while (!lights.left.empty()) {
    launch(lights, which);
    collect(lights, which);
  }
  lights.counted = {};
}

}  // namespace eikon
