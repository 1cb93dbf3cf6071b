// SPDX-License-Identifier: Apache-2.0
// The memory that units take on a device, against what is said of it beforehand.
#include "render/ready_wavefronts.h"
#include "render/scene_builder.h"
#include "wavefront/buffers.h"
#include "wavefront/memory_need.h"

namespace eikon::test {
namespace {

TEST(UnitMemory, is_what_was_counted_beforehand) {
  auto [scene, settings] = room(16, 16, 1);
  settings.aovs = {"normal"};
  const Features features(scene, settings);
  DeviceInfo info = open_devices->pool.select(as_tested({}).devices, 0, nullptr).front();
  for (const auto& [cpu, chunked] : {std::pair{true, true}, {true, false}, {false, false}, {false, true}}) {
    info.cpu = cpu;
    Execution execution;
    execution.chunked = chunked, execution.unit_paths = 1U << 15;
    const WavefrontConfig config = configure(info, execution);
    Device device(info);
    Arguments arguments;
    const WorkBuffers work(device, config, work_buffer_sizes(config, features, settings), arguments);
    device.finish();  // it is still clearing them
    EXPECT_EQ(work.bytes, unit_buffer_bytes(config, features, settings).total) << cpu << chunked;
  }
}

TEST(UnitMemory, a_replay_takes_that_of_few_paths) {
  auto [scene, settings] = room(16, 16, 1);
  Execution execution = as_tested({});
  execution.chunked = false, execution.layout = "bvh2", execution.unit_paths = 1U << 18;
  const auto radiance = [&] {
    return replay_path(scene, settings, execution, {3, 5, 0}, [](const PathVertex&) {}).radiance;
  };
  const glm::vec3 expected = radiance();
  const Features features(scene, settings);
  PackedScene packed = pack_scene(scene, features, settings);
  add_accel(packed, "bvh", "bvh2", 1);
  const DeviceInfo info = open_devices->pool.select(execution.devices, 0, nullptr).front();
  execution.memory_bytes = memory_need(packed, configure(info, execution), features, settings).total() / 2;
  EXPECT_THROW((void)output_of(scene, settings, execution), DeviceError);
  EXPECT_EQ(radiance(), expected);
}

TEST(UnitMemory, of_kept_wavefronts_is_given_up_where_the_next_one_needs_it) {
  const auto [scene, settings] = room(16, 16, 1);
  const Features features(scene, settings);
  Execution small = as_tested({});
  small.chunked = true, small.layout = "bvh8", small.unit_paths = 1U << 10;
  Execution large = small;
  large.unit_paths = 1U << 19;
  const auto packed = std::make_shared<PackedScene>(pack_scene(scene, features, settings));
  add_accel(*packed, "bvh", "bvh8", 1);
  DeviceInfo info = open_devices->pool.select(small.devices, 0, nullptr).front();
  const std::uint64_t need = memory_need(*packed, configure(info, large), features, settings).total();
  const auto kept = [&, &settings = settings](std::uint64_t memory_bytes) {
    info.memory_bytes = memory_bytes;
    DevicePool pool;
    DevicePool::Lease lease = pool.take(info);
    ReadyWavefronts& ready = ReadyWavefronts::of(lease);
    const std::uint64_t before = ready.get(lease, packed, features, settings, small).device_bytes();
    EXPECT_LE(before, need / 8) << "so little is kept where there is room";
    (void)ready.get(lease, packed, features, settings, large);
    return std::pair(ready.count() - 1, before);
  };
  const auto [beside, bytes] = kept(2 * need);
  EXPECT_EQ(beside, 1U);
  EXPECT_EQ(kept(need + bytes).first, 1U);
  EXPECT_EQ(kept(need + bytes - 1).first, 0U);
}

TEST(UnitMemory, of_wavefronts_with_idle_devices_is_given_up_too) {
  const auto [scene, settings] = room(16, 16, 1);
  const Features features(scene, settings);
  Execution execution = as_tested({});
  execution.chunked = true, execution.layout = "bvh8", execution.unit_paths = 1U << 10;
  const auto packed = std::make_shared<PackedScene>(pack_scene(scene, features, settings));
  add_accel(*packed, "bvh", "bvh8", 1);
  DeviceInfo info = open_devices->pool.select(execution.devices, 0, nullptr).front();
  const std::uint64_t need = memory_need(*packed, configure(info, execution), features, settings).total();
  const auto idle_beside = [&, &settings = settings](std::uint64_t memory_bytes) {
    DevicePool before, now = before.sibling();
    std::uint64_t bytes = 0;
    info.memory_bytes = memory_bytes;
    for (DevicePool* const pool : {&before, &now}) {
      DevicePool::Lease lease = pool->take(info);
      bytes = ReadyWavefronts::of(lease).get(lease, packed, features, settings, execution).device_bytes();
    }
    return std::pair(before.idle_count(), bytes);
  };
  const auto [beside, bytes] = idle_beside(3 * need);
  EXPECT_EQ(beside, 1U);
  EXPECT_EQ(idle_beside(need + bytes).first, 1U);
  EXPECT_EQ(idle_beside(need + bytes - 1).first, 0U);
}

}  // namespace
}  // namespace eikon::test
