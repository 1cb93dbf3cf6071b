// SPDX-License-Identifier: Apache-2.0
// What does not fit a device is said before it is uploaded.
#include "wavefront/memory_need.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;
using test::error_of;
using test::message_of;

DeviceInfo device_of(std::uint64_t memory, std::uint64_t one_buffer) {
  DeviceInfo device;
  device.name = "toaster";
  device.memory_bytes = memory;
  device.max_allocation_bytes = one_buffer;
  return device;
}

std::string refusal(const MemoryNeed& need, const DeviceInfo& device, std::uint64_t cap = 0) {
  Execution execution;
  execution.memory_bytes = cap;
  return error_of<DeviceError>([&] { require_memory(need, device, execution); });
}

constexpr std::uint64_t kMega = 1U << 20;

TEST(Memory, what_fits_is_not_refused) {
  const MemoryNeed need{300 * kMega, 200 * kMega, 100 * kMega, 0, "the textures", 300 * kMega};
  EXPECT_EQ(refusal(need, device_of(600 * kMega, 300 * kMega)), "");
  EXPECT_EQ(refusal(need, device_of(600 * kMega, 300 * kMega), 600 * kMega), "");
  EXPECT_EQ(refusal(need, device_of(600 * kMega, 300 * kMega), 900 * kMega), "") << "a cap above what there is";
}

TEST(Memory, what_does_not_fit_is_refused_with_every_figure_in_one_line) {
  const MemoryNeed need{300 * kMega, 200 * kMega, 100 * kMega, 0, "the textures", 300 * kMega};
  for (const std::string& line :
       {refusal(need, device_of(599 * kMega, 599 * kMega)), refusal(need, device_of(600 * kMega, 299 * kMega)),
        refusal(need, device_of(900 * kMega, 900 * kMega), 599 * kMega)}) {
    for (const char* part :
         {"'toaster'", "textures 300.0 MB", "geometry 200.0 MB", "paths in flight 100.0 MB", "smaller images"})
      EXPECT_TRUE(contains(line, part));
    EXPECT_FALSE(contains(line, "\n"));
  }
  EXPECT_TRUE(contains(refusal(need, device_of(599 * kMega, 599 * kMega)), "its memory is 599.0 MB"));
  EXPECT_TRUE(contains(refusal(need, device_of(600 * kMega, 299 * kMega)), "which may have 299.0 MB"));
  EXPECT_TRUE(contains(refusal(need, device_of(900 * kMega, 900 * kMega), 599 * kMega), "--memory is 599.0 MB"));
}

TEST(Memory, photons_are_counted_and_named_where_there_are_some) {
  MemoryNeed need{kMega, kMega, kMega, 0, "the textures", kMega};
  EXPECT_FALSE(contains(refusal(need, device_of(2 * kMega, 2 * kMega)), "photons"));
  need.photons = 20 * kMega;
  EXPECT_EQ(refusal(need, device_of(23 * kMega, 23 * kMega)), "");
  const std::string line = refusal(need, device_of(22 * kMega, 22 * kMega));
  EXPECT_TRUE(contains(line, "it needs 23.0 MB"));
  EXPECT_TRUE(contains(line, "photons 20.0 MB"));
  EXPECT_TRUE(contains(line, "leave out --caustics merge"));
}

TEST(Memory, a_limit_of_the_control_group_is_named) {
  DeviceInfo device = device_of(100 * kMega, 100 * kMega);
  device.memory_limit = "/sys/fs/cgroup/memory.max";
  const MemoryNeed need{300 * kMega, 200 * kMega, 100 * kMega, 0, "the textures", 300 * kMega};
  EXPECT_TRUE(contains(refusal(need, device), "what /sys/fs/cgroup/memory.max allows is 100.0 MB"));
}

TEST(Memory, a_film_beyond_what_the_process_may_have_is_refused) {
  FilmLayout layout;
  layout.width = layout.height = 1024;
  layout.crop = {0, 0, 1024, 1024};
  ASSERT_EQ(film_bytes(layout), kMega * 2 * (3 * 16 + 8));
  const auto refused = [&](bool copied, std::uint64_t packed, std::uint64_t limit) {
    return error_of<DeviceError>([&] {
      require_host_memory(layout, copied, packed, {1, "", limit, "/sys/fs/cgroup/memory.max"});
    });
  };
  EXPECT_EQ(refused(false, 8 * kMega, 136 * kMega), "") << "112 MB of sums, and 16 MB for their error";
  EXPECT_EQ(refused(true, 8 * kMega, 232 * kMega), "");
  EXPECT_EQ(refused(true, 8 * kMega, 0), "") << "not known";
  for (const std::string& line : {refused(false, 9 * kMega, 136 * kMega), refused(true, 8 * kMega, 231 * kMega)}) {
    EXPECT_TRUE(contains(line, "/sys/fs/cgroup/memory.max"));
    EXPECT_TRUE(contains(line, "--crop"));
  }
}

TEST(Memory, mostly_geometry_is_told_to_have_less_of_it) {
  const MemoryNeed need{kMega, 200 * kMega, kMega, 0, "the triangles", 150 * kMega};
  EXPECT_TRUE(contains(refusal(need, device_of(100 * kMega, 400 * kMega)), "simpler meshes"));
  EXPECT_TRUE(contains(refusal(need, device_of(100 * kMega, 400 * kMega)), "it needs 202.0 MB"));
}

TEST(Memory, what_two_levels_or_another_accelerator_or_a_smaller_picture_would_save_is_said) {
  MemoryNeed need{kMega, 200 * kMega, kMega, 150 * kMega, "the triangles", 150 * kMega};
  const DeviceInfo device = device_of(100 * kMega, 400 * kMega);
  EXPECT_TRUE(contains(refusal(need, device), "store meshes once (--instances two-level saves about 150.0 MB)"));
  need.two_level_saving = 0;
  Execution grid;
  grid.accel = "grid";
  const std::string message = message_of<DeviceError>([&] { require_memory(need, device, grid); });
  EXPECT_TRUE(contains(message, "--accel bvh"));
  need.paths = 900 * kMega;
  EXPECT_TRUE(contains(refusal(need, device), "--size"));
}

TEST(Memory, textures_count_once_and_with_the_bytes_that_their_images_have) {
  Scene scene;
  Material material;
  for (std::uint32_t i = 0; i < 2; ++i) {
    TextureImage image;
    image.width = 64, image.height = 32;
    image.rgba8.resize(64 * 32);
    scene.images.push_back(image);
  }
  material.base_color_texture = Texture{};
  material.emissive_texture = Texture{};  // the same image
  material.metallic_roughness_texture = Texture{};
  material.metallic_roughness_texture->image = 1;
  scene.materials = {material, material};
  Primitive primitive;
  primitive.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  primitive.uv[0].assign(3, {0, 0});
  primitive.indices = {0, 1, 2};
  scene.meshes.push_back({"mesh", {primitive}});
  scene.nodes.emplace_back();
  const Settings settings;
  const Features features(scene, settings);
  PackedScene packed = pack_scene(scene, features, settings);
  add_accel(packed, "bvh", "bvh8", 1);
  WavefrontConfig config;
  config.layout = "bvh8";
  const MemoryNeed need = memory_need(packed, config, features, settings);
  EXPECT_EQ(need.textures, 4U * (EK_TEXEL_TABLE + 2 * 64 * 32));
  EXPECT_EQ(need.total(), packed.bytes("bvh8") + need.paths);
  // The pictures themselves are not copied.
  ASSERT_EQ(packed.texels.size(), 3U);
  EXPECT_EQ(packed.texels[1].data(), scene.images[0].rgba8.data());
}

/// A scene of one triangle, packed with its tree for devices that launch each stage.
struct OneTriangle {
  explicit OneTriangle(const Settings& with = {})
      : settings(with), scene(scene_of(settings)), features(scene, settings) {
    packed = pack_scene(scene, features, settings);
    add_accel(packed, "bvh", "bvh2", 1);
  }
  static Scene scene_of(const Settings& settings) {
    Scene scene;
    scene.materials.resize(1);
    if (settings.light_samples > 1) scene.materials[0].emission = {1, 1, 1};
    Primitive primitive;
    primitive.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.indices = {0, 1, 2};
    scene.meshes.push_back({"mesh", {primitive}});
    scene.nodes.emplace_back();
    return scene;
  }
  Settings settings;
  Scene scene;
  Features features;
  PackedScene packed;
};

/// A large GPU.
DeviceInfo gpu_of(std::uint64_t memory, std::uint64_t one_buffer) {
  DeviceInfo device = device_of(memory, one_buffer);
  device.gpu = true, device.compute_units = 128;
  return device;
}

TEST(Memory, all_buffers_of_units_count) {
  const OneTriangle of;
  const auto buffers_of = [&](std::uint32_t paths) {
    Execution execution;
    execution.unit_paths = paths;
    const WavefrontConfig config = configure(gpu_of(80000 * kMega, 20000 * kMega), execution);
    return unit_buffer_bytes(config, of.features, of.settings);
  };
  const UnitBufferBytes small = buffers_of(1U << 16), large = buffers_of(1U << 17);
  const std::uint64_t words = path_state_layout(of.features, false).words,
                      channels = of.features.film_channels().size();
  const std::uint64_t queues = 8 + 4;  // of rays and shadow rays
  EXPECT_GE(large.total - small.total, 65536 * (4 * (words + channels) + queues));
  EXPECT_EQ(large.largest, 4 * words * ((1U << 17) + EK_PAD)) << "the state, and what kernels may read behind it";
}

TEST(Memory, the_largest_buffer_of_units_is_as_large_as_it_is_allocated) {
  const OneTriangle of;
  const std::uint64_t words = path_state_layout(of.features, false).words;
  const auto capacity = [&](std::uint64_t one_buffer) {
    const DeviceInfo device = gpu_of(80000 * kMega, one_buffer);
    return configure(device, fit_units(of.packed, device, of.features, of.settings, {})).capacity();
  };
  EXPECT_EQ(capacity(4 * words * ((1U << 20) + EK_PAD)), 1U << 20);
  EXPECT_EQ(capacity(4 * words * ((1U << 20) + EK_PAD) - 4), 1U << 19);
}

TEST(Memory, the_units_of_a_gpu_are_as_large_as_fits) {
  const OneTriangle of;
  const auto capacity = [&](std::uint64_t memory, std::uint64_t one_buffer) {
    const DeviceInfo device = gpu_of(memory * kMega, one_buffer * kMega);
    const WavefrontConfig config = configure(device, fit_units(of.packed, device, of.features, of.settings, {}));
    EXPECT_EQ(refusal(memory_need(of.packed, config, of.features, of.settings), device), "") << memory;
    return config.capacity();
  };
  EXPECT_EQ(capacity(80000, 20000), 1U << 25);
  EXPECT_EQ(capacity(4096, 1024), 1U << 22) << "units take a quarter of the memory";
  EXPECT_LE(capacity(80000, 40), 1U << 19) << "the state of all paths is one buffer";
  const std::uint32_t little = capacity(2, 2);
  EXPECT_GE(little, 1U << 10);
  EXPECT_LT(little, 1U << 14) << "also below the least capacity of other devices";
}

TEST(Memory, units_that_are_asked_for_are_given_as_far_as_kernels_can_number_their_words) {
  Settings settings;
  settings.light_samples = 16;
  const OneTriangle of(settings);
  ASSERT_GT(path_state_layout(of.features, false).words, 128U) << "2^25 paths have more than 2^32 words";
  const DeviceInfo device = gpu_of(800000 * kMega, 400000 * kMega);
  const auto capacity = [&](std::uint32_t asked) {
    Execution execution;
    execution.unit_paths = asked;
    return configure(device, fit_units(of.packed, device, of.features, of.settings, execution)).capacity();
  };
  EXPECT_EQ(capacity(1U << 20), 1U << 20);
  EXPECT_EQ(capacity(1U << 25), 1U << 24);
  EXPECT_EQ(capacity(0), 1U << 24);
}

TEST(Memory, units_of_few_paths_are_no_larger_and_leave_room_for_what_is_beside_them) {
  const OneTriangle of;
  const DeviceInfo device = gpu_of(100 * kMega, 100 * kMega);
  const auto capacity = [&](std::uint32_t asked, const UnitRoom& room) {
    Execution execution;
    execution.unit_paths = asked;
    return configure(device, fit_units(of.packed, device, of.features, of.settings, execution, room)).capacity();
  };
  EXPECT_EQ(capacity(0, {.most_paths = 1U << 14}), 1U << 14);
  EXPECT_EQ(capacity(1U << 12, {.most_paths = 1U << 14}), 1U << 12);
  EXPECT_EQ(capacity(1U << 20, {.most_paths = 1U << 14}), 1U << 14);
  const std::uint32_t usual = capacity(0, {});
  EXPECT_LT(capacity(0, {.beside_bytes = 90 * kMega}), usual);
  EXPECT_EQ(capacity(usual, {.beside_bytes = 90 * kMega}), usual) << "asked for";
  EXPECT_LT(capacity(usual, {.most_paths = usual, .beside_bytes = 90 * kMega}), usual);
}

TEST(Memory, a_single_chunk_that_does_not_fit_stays) {
  const OneTriangle of;
  DeviceInfo device = device_of(kMega, kMega);
  device.cpu = true;
  Execution execution;
  execution.chunk = 4096;
  execution.layout = "bvh2";
  const Execution fitted = fit_units(of.packed, device, of.features, of.settings, execution, {.most_paths = 1U << 14});
  EXPECT_EQ(configure(device, fitted).capacity(), 4096U);
}

}  // namespace
}  // namespace eikon
