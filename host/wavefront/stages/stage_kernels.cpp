// SPDX-License-Identifier: Apache-2.0
#include "wavefront/stages/stage_kernels.h"

namespace eikon {

StageKernels::StageKernels(Device& device, const WavefrontConfig& config, const Program& program,
                           std::span<const std::string> stages)
    : device_(&device), config_(config) {
  for (const std::string& stage : stages) kernels_[stage] = program.kernel(stage);
}

void StageKernels::bind(const Arguments& arguments) {
  for (auto& [stage, kernel] : kernels_) kernel.bind(arguments);
}

void StageKernels::warm_up() {
  for (const auto& [stage, kernel] : kernels_) device_->run(kernel, 1, config_.chunked ? 1 : kWorkGroup);
}

void StageKernels::run(const std::string& stage, std::uint32_t depth, std::uint64_t paths, std::uint64_t active) {
  const auto found = kernels_.find(stage);
  if (found == kernels_.end()) return;
  found->second.set("depth", depth);
  if (config_.chunked)
    device_->run(found->second, chunks(paths), 1);
  else
    device_->run(found->second, divide_up(active, kWorkGroup), kWorkGroup);
}

std::size_t StageKernels::chunks(std::uint64_t paths) const {
  return config_.chunked ? divide_up(paths, config_.chunk) : 1;
}

QueueCounts StageKernels::read_counts(const Buffer& counts, std::uint32_t depth, std::uint64_t paths) {
  std::vector<std::uint32_t> words(kQueueWords * chunks(paths));
  device_->read(counts, words.data(), 4 * words.size());
  return total_counts(words, depth);
}

}  // namespace eikon
