// SPDX-License-Identifier: Apache-2.0
// Decisions by device, without one.
#include "wavefront/config.h"

#include <gtest/gtest.h>

namespace eikon::test {
namespace {

DeviceInfo processor(std::uint32_t cores) {
  DeviceInfo info;
  info.cpu = true;
  info.compute_units = cores;
  info.native_float_lanes = 16;
  info.memory_bytes = std::uint64_t{16} << 30;
  return info;
}

TEST(WavefrontConfig, a_cpu_runs_chunks_through_all_stages_with_one_work_item_per_core) {
  const WavefrontConfig config = configure(processor(2), {});
  EXPECT_TRUE(config.chunked && config.fused);
  EXPECT_EQ(config.lanes, 16U);
  EXPECT_EQ(config.workers, 2U);
  EXPECT_EQ(config.held_chunks(), 2U);
  EXPECT_GE(config.chunks, 32 * config.workers);
}

TEST(WavefrontConfig, many_cores_have_enough_chunks_each_and_paths_keep_exact_numbers) {
  for (const std::uint32_t cores : {1U, 4U, 16U, 64U, 256U}) {
    const WavefrontConfig config = configure(processor(cores), {});
    EXPECT_EQ(config.workers, cores);
    EXPECT_GE(config.capacity(), 1U << 18);
    EXPECT_LE(config.capacity(), 1U << 23);
    const std::uint32_t each = cores <= 64 ? 32 : 8;
    EXPECT_GE(config.chunks, each * cores) << cores << " cores";
    EXPECT_GE(config.pixels, kBlockPixels);
    EXPECT_GE(16 * config.pixels, config.capacity()) << "a pass of few samples fills a unit, too";
  }
}

TEST(WavefrontConfig, unfused_the_state_of_all_paths_is_held) {
  Execution execution;
  execution.fused = false;
  const WavefrontConfig config = configure(processor(2), execution);
  EXPECT_FALSE(config.fused);
  EXPECT_EQ(config.held_chunks(), config.chunks);
}

TEST(WavefrontConfig, a_gpu_has_queues_and_launches_each_stage) {
  DeviceInfo info = processor(100);
  info.cpu = false, info.gpu = true, info.native_float_lanes = 1;
  Execution execution;
  for (const auto& fused : {std::optional<bool>(), std::optional<bool>(true)}) {
    execution.fused = fused;
    const WavefrontConfig config = configure(info, execution);
    EXPECT_FALSE(config.chunked || config.fused);
    EXPECT_EQ(config.lanes, 1U);
    EXPECT_EQ(config.capacity(), 1U << 24);
    EXPECT_EQ(config.pixels, 1U << 19);
  }
}

TEST(WavefrontConfig, the_units_of_a_gpu_grow_with_its_compute_units_as_far_as_its_memory_allows) {
  DeviceInfo info;
  info.gpu = true;
  info.memory_bytes = std::uint64_t{80} << 30;
  for (const std::uint32_t units : {1U, 20U, 28U, 60U, 132U, 1000U}) {
    info.compute_units = units;
    const WavefrontConfig config = configure(info, {});
    EXPECT_GE(config.capacity(), 1U << 20);
    EXPECT_GE(config.capacity(), std::min(4 * units * 2048, 1U << 25));
    EXPECT_LE(config.capacity(), 1U << 25);
    EXPECT_GE(config.pixels, kBlockPixels);
    EXPECT_LE(config.pixels, std::max(kBlockPixels, config.capacity() / 16));
  }
  info.memory_bytes = std::uint64_t{1} << 30;
  EXPECT_LE(configure(info, {}).capacity(), 1U << 20);
}

TEST(WavefrontConfig, a_processor_has_no_more_paths_in_a_unit_than_its_kernels_can_number) {
  Execution execution;
  execution.unit_paths = 1U << 25;
  EXPECT_LE(configure(processor(8), execution).capacity(), 1U << 23);
  execution.chunked = false;
  EXPECT_EQ(configure(processor(8), execution).capacity(), 1U << 25) << "one lane has exact integers";
}

TEST(WavefrontConfig, what_is_asked_for_is_given_and_little_memory_makes_the_pool_small) {
  Execution execution;
  execution.unit_paths = 3000, execution.chunk = 50;
  WavefrontConfig config = configure(processor(8), execution);
  EXPECT_EQ(config.chunk, 48U);
  EXPECT_EQ(config.chunks, 62U);
  execution = {};
  execution.memory_bytes = std::uint64_t{32} << 20;
  config = configure(processor(8), execution);
  EXPECT_LE(config.capacity(), 1U << 15);
  execution.unit_paths = 64;
  EXPECT_EQ(configure(processor(8), execution).capacity(), 64U) << "a chunk is not larger than the unit";
  execution = {};
  EXPECT_EQ(configure(processor(2), execution).pixels, kBlockPixels);
  execution.block = 300;
  EXPECT_EQ(configure(processor(2), execution).pixels, 300U * 300);
}

TEST(WavefrontConfig, a_gpu_with_very_little_memory_has_a_pool_that_fits_into_a_quarter_of_it) {
  DeviceInfo info = processor(100);
  info.cpu = false, info.gpu = true, info.native_float_lanes = 1;
  Execution execution;
  execution.memory_bytes = std::uint64_t{4} << 20;
  EXPECT_EQ(configure(info, execution).capacity(), 4096U);
  execution.memory_bytes = 1000;
  EXPECT_EQ(configure(info, execution).capacity(), 1024U) << "smaller units would only be slower";
}

TEST(WavefrontConfig, processors_by_unknown_drivers_get_portable_kernels) {
  DeviceInfo info = processor(2);
  const auto is_portable = [&] {
    return program_options(info, configure(info, {}), Features(Scene{}, Settings{}),
                           Accel{.name = "bvh", .layout = "bvh2"}, {})
               .defines.count("EK_PORTABLE") != 0;
  };
  EXPECT_TRUE(is_portable());
  info.cycle_counter = true;  // as PoCL, Intel and Oclgrind
  EXPECT_FALSE(is_portable());
  info.cpu = false, info.gpu = true, info.cycle_counter = false;
  EXPECT_FALSE(is_portable());
}

}  // namespace
}  // namespace eikon::test
