// SPDX-License-Identifier: Apache-2.0
#include "wavefront/stages/stage_sampler.h"

#include <algorithm>

namespace eikon {
namespace {

constexpr std::uint64_t kOfFirstUnit = 32, kOfAll = 256;
constexpr std::uint64_t kLeast = 256;  // paths: fewer do not fill the lanes
constexpr std::size_t kRun = 16;       // pixels; of unit_pixels a 4 x 4 tile

}  // namespace

StageSampler::StageSampler(Device& device, const Program& program, const std::vector<std::string>& stages,
                           const Arguments& arguments, const WavefrontConfig& config)
    : device_(device), config_(config), stages_(stages), kernels_(device, config, program, stages) {
  frame_ = device.allocate(sizeof(Frame));
  pixels_ = device.allocate(4 * std::size_t{config.chunk} * config.workers);
  counts_ = arguments.buffers().at("counts");
  bind(arguments);
  const Frame nothing{};
  device.write(frame_, &nothing, sizeof nothing);
  kernels_.warm_up();
  device.finish();
}

void StageSampler::bind(const Arguments& arguments) {
  Arguments own = arguments;
  own.set("frame", frame_);
  own.set("pixels", pixels_);
  kernels_.bind(own);
}

std::vector<std::uint32_t> StageSampler::choose_pixels(std::span<const std::uint32_t> pixels, std::size_t count) {
  std::vector<std::uint32_t> chosen;
  const std::size_t runs = divide_up(count, kRun), there = divide_up(pixels.size(), kRun);
  for (std::size_t run = 0; run < runs && chosen.size() < count; ++run) {
    const std::size_t begin = (2 * run + 1) * there / (2 * runs) * kRun;
    const std::size_t end = std::min({begin + kRun, pixels.size(), begin + count - chosen.size()});
    for (std::size_t i = begin; i < end; ++i) chosen.push_back(pixels[i]);
  }
  return chosen;
}

void StageSampler::before(const Frame& frame, std::span<const std::uint32_t> pixels) {
  const std::uint64_t paths = frame.path_count;
  const std::uint64_t most = std::min(paths / kOfFirstUnit, std::uint64_t{config_.chunk} * config_.workers);
  const bool due = most >= kLeast && (sampled_ == 0 || (sampled_ + most) * kOfAll <= rendered_ + paths);
  rendered_ += paths;
  if (!due) return;
  const std::vector<std::uint32_t> chosen = choose_pixels(pixels, std::min<std::size_t>(pixels.size(), most));
  Frame part = frame;
  part.pixel_count = std::uint32_t(chosen.size());
  part.sample_count = std::min(frame.sample_count, std::uint32_t(most / chosen.size()));
  part.path_count = part.pixel_count * part.sample_count;
  sampled_ += part.path_count;
  device_.finish();  // otherwise work that was enqueued before would count
  const auto taken = device_.profiler().apart("sampling", [&] {
    device_.write(frame_, &part, sizeof part);
    device_.write(pixels_, chosen.data(), 4 * chosen.size());
    run(part.path_count);
    device_.finish();
  });
  double sum = 0;
  for (const std::string& stage : stages_) sum += seconds_[stage] += taken.at(stage).seconds;
  for (const auto& [stage, seconds] : seconds_) shares_[stage] = sum > 0 ? seconds / sum : 0;
}

void StageSampler::run(std::uint32_t path_count) {
  std::uint64_t active = path_count;
  for (std::uint32_t depth = 1; active > 0; ++depth) {
    for (const std::string& stage : stages_)
      if (stage != "generate" || depth == 1) kernels_.run(stage, depth, path_count, active);
    active = kernels_.read_counts(counts_, depth, path_count).next_paths;
  }
}

}  // namespace eikon
