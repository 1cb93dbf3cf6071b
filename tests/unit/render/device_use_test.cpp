// SPDX-License-Identifier: Apache-2.0
// The share of its time in which a fast GPU traces paths, in a simulation of how it is driven: the
// units that the schedule gives it, a fixed cost of each depth, and the time that sums take on
// their way to the film. The rate, the cost of a depth and that of adding sums are those of an
// NVIDIA H200 and its host with cornell.gltf (tools/gpu/MODEL.md). The others are estimates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "render/device_worker.h"

namespace eikon {
namespace {

constexpr double kRate = 600e6;             // paths per second, while all of the device is at work
constexpr double kDepth_s = 60e-6;          // fixed cost of a depth: launches of four kernels, and the latency of each
constexpr double kFilm_s = 25e-6;           // fixed cost of stage film and of what is read back in the queue
constexpr double kSlots_s = 12 / 3e12;      // per path: stage film reads its slots
constexpr double kRead_s = 56 / 6e9;        // per pixel: packed sums are read back
constexpr double kAdd_s = 0.85e-3 / 16384;  // per pixel: a processor of the host adds them to the film
constexpr double kAdders = 8;               // processors that add the sums of a large block

DeviceInfo h200() {
  DeviceInfo info;
  info.gpu = true;
  info.compute_units = 132;
  info.memory_bytes = std::uint64_t{139} << 30;
  info.max_allocation_bytes = info.memory_bytes / 4;
  return info;
}

/// Paths that reach each depth of a unit of cornell.gltf, until none is left.
std::vector<double> alive_by_depth(double paths) {
  std::vector<double> alive = {1, 0.93, 0.68, 0.38, 0.21, 0.11, 0.061, 0.033};
  for (double& share : alive) share *= paths;
  while (alive.back() * 0.53 >= 1) alive.push_back(alive.back() * 0.53);
  std::erase_if(alive, [](double count) { return count < 1; });
  return alive;
}

struct Use {
  double busy = 0;  // share of the time in which paths are traced at the full rate
  double paths_per_unit = 0;
  double sums_per_path = 0;  // pixels whose sums are read back, for each path
  double thin_share = 0;     // of the time, for depths with less than a tenth of the paths
};

/// A device of this rate, and the thread that drives it.
struct Driven {
  double device_s = 0;  // when the device has done what it was given,
  double host_s = 0;    // and when the thread is free
  double thin_s = 0;    // time of depths with less than a tenth of the unit's paths

  void run_depth(double paths, double of_unit) {
    const double seconds = kDepth_s + paths / kRate / 3.44;  // 3.44 depths for each path
    device_s = std::max(device_s, host_s) + seconds;
    if (paths < 0.1 * of_unit) thin_s += seconds;
  }
};

/// Renders a picture as process_units() and WavefrontRunner do: the next unit begins when all
/// depths of the one before are launched, and its first depth runs while the host waits for the
/// sums.
/// beside  sums are added by threads of their own, which are done with a unit before the next but
///         one begins; else by one thread
Use simulate(const UnitLimits& limits, std::uint32_t side, const WorkUnit& picture, bool beside) {
  Schedule schedule(1, side);
  schedule.join(0, limits);
  schedule.open({picture});
  Driven driven;
  double since_s = 0, added_s = 0, units = 0, pixels = 0;
  std::optional<Schedule::Assignment> now = schedule.next(0, 0);
  driven.run_depth(double(now->unit.path_count()), double(now->unit.path_count()));
  while (now) {
    const WorkUnit unit = now->unit;
    const std::vector<double> alive = alive_by_depth(double(unit.path_count()));
    for (std::size_t depth = 1; depth < alive.size(); ++depth) driven.run_depth(alive[depth], alive[0]);
    driven.host_s = std::max({driven.host_s, driven.device_s, added_s});
    driven.device_s += kFilm_s + alive[0] * kSlots_s;
    const double summed_s = driven.device_s + double(unit.block.pixel_count()) * kRead_s;
    const std::optional<Schedule::Assignment> next = schedule.next(0, driven.host_s);
    if (next) driven.run_depth(double(next->unit.path_count()), double(next->unit.path_count()));
    driven.host_s = std::max(driven.host_s, summed_s);
    EXPECT_TRUE(schedule.finished(now->id, since_s, driven.host_s));
    since_s = driven.host_s;
    const double add_s = double(unit.block.pixel_count()) * kAdd_s;
    added_s = std::max(added_s, driven.host_s) + (beside ? add_s / kAdders : add_s);
    if (!beside) driven.host_s = added_s;
    ++units, pixels += double(unit.block.pixel_count());
    now = next;
  }
  EXPECT_TRUE(schedule.complete());
  const auto paths = double(picture.path_count());
  const double end_s = std::max(driven.host_s, added_s);
  return {paths / kRate / end_s, paths / units, pixels / paths, driven.thin_s / end_s};
}

WorkUnit picture_of(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  return {{0, 0, width, height}, 0, spp};
}

void print(const char* of, const Use& use) {
  std::printf(
      "%s: busy %.3f, %.0f paths a unit, %.2f bytes of sums a path, %.3f of the time for the last tenth of the paths\n",
      of, use.busy, use.paths_per_unit, 56 * use.sums_per_path, use.thin_share);
}

TEST(DeviceUse, an_h200_is_busy_with_paths_for_most_of_the_time) {
  const WavefrontConfig config = configure(h200(), {});
  const UnitLimits limits = unit_limits(config, h200());
  struct Picture {
    std::uint32_t width, height;
    std::uint64_t spp;
    double busy, thin_share;
  };
  for (const auto& [width, height, spp, busy, thin_share] : {Picture{1920, 1080, 64, 0.88, 0.11},
                                                             {3840, 2160, 64, 0.92, 0.09},
                                                             {1920, 1080, 256, 0.93, 0.09},
                                                             {1024, 1024, 64, 0.85, 0.13},
                                                             {512, 512, 256, 0.85, 0.14},
                                                             {512, 512, 64, 0.7, 0.23}}) {
    const Use use = simulate(limits, std::max(width, height), picture_of(width, height, spp), true);
    print((std::to_string(width) + "x" + std::to_string(height) + ", " + std::to_string(spp) + " samples").c_str(),
          use);
    EXPECT_GE(use.busy, busy) << width << "x" << height << ", " << spp;
    EXPECT_GE(use.paths_per_unit, 4.0 * 132 * 2048);
    EXPECT_LE(use.thin_share, thin_share) << width << "x" << height << ", " << spp;
  }
}

/// Paths and largest block that each of two devices has of a picture. The first is an H200, the
/// second has other limits and another rate.
struct Share {
  std::uint64_t paths = 0, most_pixels = 0, most_samples = 0;
};
std::array<Share, 2> share_with(const UnitLimits& limits, double rate) {
  Schedule schedule(2, 1920);
  schedule.join(0, unit_limits(configure(h200(), {}), h200()));
  schedule.join(1, limits);
  schedule.open({picture_of(1920, 1080, 64)});
  std::array<Share, 2> shares;
  std::array<std::optional<Schedule::Assignment>, 2> units;
  std::array<double, 2> begin_s{}, end_s{};
  for (double now_s = 0; !schedule.complete() && now_s < 10; now_s += 1e-4)
    for (std::size_t i = 0; i < 2; ++i) {
      if (units[i] && end_s[i] <= now_s) {
        const WorkUnit unit = units[i]->unit;
        if (schedule.finished(units[i]->id, begin_s[i], end_s[i])) shares[i].paths += unit.path_count();
        units[i].reset();
      }
      if (units[i] || !(units[i] = schedule.next(i, now_s))) continue;
      const WorkUnit& unit = units[i]->unit;
      begin_s[i] = now_s;
      end_s[i] = now_s + 1e-4 + double(unit.path_count()) / (i == 0 ? kRate : rate);
      shares[i].most_pixels = std::max(shares[i].most_pixels, unit.block.pixel_count());
      shares[i].most_samples = std::max(shares[i].most_samples, unit.sample_end - unit.sample_begin);
    }
  EXPECT_TRUE(schedule.complete());
  return shares;
}

DeviceInfo processor(std::uint32_t cores) {
  DeviceInfo info;
  info.cpu = true, info.compute_units = cores, info.native_float_lanes = 16;
  info.memory_bytes = std::uint64_t{64} << 30;
  return info;
}

TEST(DeviceUse, a_cpu_beside_an_h200_has_units_that_fill_its_cores) {
  const DeviceInfo cpu = processor(64);
  const auto [of_gpu, of_cpu] = share_with(unit_limits(configure(cpu, {}), cpu), 100e6);
  EXPECT_EQ(of_gpu.paths + of_cpu.paths, picture_of(1920, 1080, 64).path_count());
  EXPECT_GT(of_gpu.most_pixels, kBlockPixels);
  EXPECT_EQ(of_gpu.most_samples, 64U);
  EXPECT_GT(of_cpu.paths, of_gpu.paths / 10);
  EXPECT_LE(of_cpu.most_pixels, configure(cpu, {}).pixels);
  EXPECT_GE(of_cpu.most_pixels * of_cpu.most_samples, 64U << 16);
}

/// Paths that a core has of a unit, the median over the picture, where one device renders it alone.
double paths_per_core(std::uint32_t cores, const WorkUnit& picture, double rate_of_core) {
  const DeviceInfo cpu = processor(cores);
  Schedule schedule(1, std::max(picture.block.width(), picture.block.height()));
  schedule.join(0, unit_limits(configure(cpu, {}), cpu));
  schedule.open({picture});
  std::vector<std::uint64_t> sizes;
  double now_s = 0;
  while (const std::optional<Schedule::Assignment> unit = schedule.next(0, now_s)) {
    const double begin_s = now_s;
    now_s += 2e-4 + double(unit->unit.path_count()) / (rate_of_core * cores);
    EXPECT_TRUE(schedule.finished(unit->id, begin_s, now_s));
    sizes.insert(sizes.end(), std::size_t(unit->unit.path_count() >> 12), unit->unit.path_count());
  }
  EXPECT_TRUE(schedule.complete());
  std::ranges::sort(sizes);
  return double(sizes[sizes.size() / 2]) / cores;
}

// With 16,384 paths for each of two cores cornell.gltf was rendered at .74 of the rate of large
// units, and with 4,096 at .58.
TEST(DeviceUse, the_cores_of_a_large_processor_have_many_paths_each) {
  for (const std::uint32_t cores : {2U, 8U, 16U, 32U, 64U})
    EXPECT_GE(paths_per_core(cores, picture_of(1280, 720, 64), 3e6), 50'000) << cores << " cores";
  EXPECT_GE(paths_per_core(128, picture_of(1920, 1080, 64), 3e6), 30'000);
  EXPECT_GE(paths_per_core(64, picture_of(1280, 720, 16), 3e6), 50'000) << "16 samples of each pixel";
}

TEST(DeviceUse, small_blocks_or_sums_added_by_the_thread_that_launches_would_leave_it_idle) {
  const UnitLimits small{.capacity = 1U << 20, .grain = 1U << 17};
  const Use of_small = simulate(small, 128, picture_of(1920, 1080, 64), false);
  print("blocks of 128x128 pixels", of_small);
  EXPECT_LT(of_small.busy, 0.4);
  const UnitLimits limits = unit_limits(configure(h200(), {}), h200());
  const WorkUnit large = picture_of(3840, 2160, 64);
  const Use of_one_thread = simulate(limits, 3840, large, false);
  print("3840x2160, one thread", of_one_thread);
  EXPECT_LT(of_one_thread.busy, simulate(limits, 3840, large, true).busy - 0.1);
}

}  // namespace
}  // namespace eikon
