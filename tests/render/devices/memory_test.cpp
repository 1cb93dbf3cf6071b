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

}  // namespace
}  // namespace eikon::test
