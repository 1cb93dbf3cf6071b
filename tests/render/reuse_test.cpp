// SPDX-License-Identifier: Apache-2.0
// Devices, programs and packed scenes serve one render after the other, with the bits of fresh ones.
#include <stdexcept>

#include "render/scene_builder.h"

namespace eikon::testing {
namespace {

TEST(Reuse, devices_and_packed_scenes_give_the_bits_of_fresh_ones) {
  const auto [scene, settings] = room(64, 48, 8);
  Settings other = settings;
  other.seed = 7;
  other.sample_end = 5;
  const Execution execution;
  const std::atomic<bool> stop{false};
  const Film first = render(scene, settings, execution, stop).film;
  const Film second = render(scene, other, execution, stop).film;

  DevicePool devices;
  const Features features(scene, settings);
  const auto packed = std::make_shared<PackedScene>(pack_scene(scene, features, settings));
  const auto again = [&](const Settings& now) {
    RenderHooks hooks;
    hooks.devices = &devices;
    return render_packed(packed, features, now, execution, stop, hooks);
  };
  const RenderOutput cold = again(settings);
  EXPECT_TRUE(same_film(cold.film, first));
  const std::size_t trees = packed->accels.size();
  for (int i = 0; i < 3; ++i) {
    const RenderOutput warm = again(other);
    EXPECT_TRUE(same_film(warm.film, second));
    EXPECT_EQ(warm.report.build_s, 0) << "the tree was there";
    EXPECT_EQ(warm.report.devices.front().samples, second.layout().crop.pixel_count() * 5) << "counts begin anew";
    EXPECT_TRUE(same_film(again(settings).film, first));
  }
  EXPECT_EQ(packed->accels.size(), trees);
}

TEST(Reuse, a_device_comes_back_unless_it_failed) {
  const DeviceInfo info = select_devices("all").front();
  DevicePool devices;
  const Device* first = nullptr;
  {
    const DevicePool::Lease lease = devices.take(info);
    first = &*lease;
    lease->profiler().record("work", 0, 1, 1, 0);
    const DevicePool::Lease another = devices.take(info);
    EXPECT_NE(&*another, first) << "it is taken";
  }
  {
    const DevicePool::Lease a = devices.take(info), b = devices.take(info);
    EXPECT_TRUE(&*a == first || &*b == first);
    EXPECT_TRUE(a->profiler().totals().empty() && b->profiler().totals().empty());
  }
  EXPECT_EQ(devices.idle_count(), 2U);
  try {
    const DevicePool::Lease lease = devices.take(info);
    throw std::runtime_error("it failed");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(devices.idle_count(), 1U);
  devices.take(info).discard();
  EXPECT_EQ(devices.idle_count(), 0U);
  const std::vector<std::uint32_t> words = {1, 2, 3};
  const DevicePool::Lease fresh = devices.take(info);
  EXPECT_EQ(fresh->read_all<std::uint32_t>(fresh->upload(words)), words);
}

TEST(Reuse, a_program_that_was_built_is_not_built_again) {
  Device device(select_devices("all").front());
  const std::string text = "kernel void nothing(global uint* a) { a[0] = EK_VALUE; }\n";
  const auto run = [&](const char* value) {
    ProgramOptions options;
    options.defines["EK_VALUE"] = value;
    const Program program = device.build(text, options);
    Arguments arguments;
    const Buffer out = device.allocate(4);
    arguments.set("a", out);
    Kernel kernel = program.kernel("nothing");
    kernel.bind(arguments);
    device.run(kernel, 1, 1);
    return device.read_all<std::uint32_t>(out).front();
  };
  EXPECT_EQ(run("5"), 5U);
  EXPECT_EQ(run("6"), 6U) << "other defines are another program";
  EXPECT_EQ(run("5"), 5U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(run(std::to_string(i).c_str()), std::uint32_t(i)) << "more than are kept";
}

}  // namespace
}  // namespace eikon::testing
