// SPDX-License-Identifier: Apache-2.0
// Room for the tables of a pilot beside the units of devices.
#include <gtest/gtest.h>

#include "render/pilot/pilot_thread.h"
#include "wavefront/memory_need.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMebi = 1U << 20;

/// One GPU that is to render a triangle, with units that fit it as long as nothing is guided.
struct OneGpu {
  OneGpu(std::uint64_t memory, std::uint32_t asked_unit_paths) : scene(std::make_shared<Scene>()) {
    Primitive primitive;
    primitive.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.indices = {0, 1, 2};
    scene->materials.resize(1);
    scene->materials[0].emission = {1, 1, 1};
    scene->meshes.push_back({"mesh", {primitive}});
    scene->nodes.emplace_back();
    Settings settings;
    settings.guiding = Guiding::on;
    settings.pilot_paths = 1U << 15;
    const Features features(*scene, settings);
    DeviceInfo info;
    info.gpu = true, info.compute_units = 128;
    info.memory_bytes = info.max_allocation_bytes = memory;
    const std::shared_ptr<PackedScene> packed = share(pack_scene(*scene, features, settings), scene);
    add_accel(*packed, "bvh", "bvh2", 1);
    Execution execution;
    execution.unit_paths = asked_unit_paths;
    execution = fit_units(*packed, info, features, settings, execution);
    devices = std::make_shared<WavefrontDevices>(WavefrontDevices{.devices = {info},
                                                                  .executions = {execution},
                                                                  .packed = packed,
                                                                  .features = features,
                                                                  .settings = settings,
                                                                  .film = {},
                                                                  .pool = {},
                                                                  .asked_unit_paths = asked_unit_paths});
  }
  [[nodiscard]] std::uint32_t capacity() const {
    return configure(devices->devices[0], devices->executions[0]).capacity();
  }
  /// Prepares a pilot with a table of that many bytes. Returns the notes for the user.
  std::vector<std::string> prepare(std::uint64_t table_bytes) {
    Pilot pilot;
    GuideTable table;
    table.cells.resize(table_bytes / 4);
    table.roulette_depth = 1;
    pilot.table = std::make_shared<const GuideTable>(std::move(table));
    RenderHooks hooks;
    hooks.pilot = [&] { return std::optional(pilot); };
    std::vector<DeviceReport> prepared(1);
    const std::atomic<bool> never{false};
    RenderReport report;
    prepare_pilot(*devices, prepared, never, hooks, report);
    return report.notes;
  }
  std::shared_ptr<Scene> scene;
  std::shared_ptr<WavefrontDevices> devices;
};

TEST(PilotMemory, units_make_room_for_the_tables_where_they_were_not_asked_for) {
  OneGpu usual(64 * kMebi, 0);
  const std::uint32_t before = usual.capacity();
  EXPECT_TRUE(usual.prepare(56 * kMebi).empty());
  EXPECT_NE(usual.devices->settings.guide, nullptr);
  EXPECT_LT(usual.capacity(), before);

  OneGpu asked(64 * kMebi, before);
  EXPECT_EQ(asked.prepare(56 * kMebi).size(), 1U);
  EXPECT_EQ(asked.devices->settings.guide, nullptr);
  EXPECT_EQ(asked.capacity(), before);
}

TEST(PilotMemory, units_stay_where_tables_do_not_fit_or_there_is_room_for_them) {
  OneGpu small(64 * kMebi, 0), large(64 * kMebi, 0);
  const std::uint32_t before = small.capacity();
  EXPECT_EQ(small.prepare(65 * kMebi).size(), 1U);
  EXPECT_EQ(small.devices->settings.guide, nullptr);
  EXPECT_EQ(small.capacity(), before);
  EXPECT_TRUE(large.prepare(kMebi).empty());
  EXPECT_EQ(large.capacity(), before);
}

}  // namespace
}  // namespace eikon
