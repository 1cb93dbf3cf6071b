// SPDX-License-Identifier: Apache-2.0
// The memory that units take on a device, against what is said of it beforehand.
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
    EXPECT_EQ(work.bytes, path_pool_bytes(config, features, settings).total) << cpu << chunked;
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

}  // namespace
}  // namespace eikon::test
