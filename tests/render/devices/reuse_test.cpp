// SPDX-License-Identifier: Apache-2.0
// Devices, programs and packed scenes serve one render after the other, with the bits of fresh
// ones.
#include <stdexcept>

#include "render/device_prefetcher.h"
#include "render/scene_builder.h"
#include "support/messages.h"

namespace eikon::test {
namespace {

TEST(Reuse, devices_and_packed_scenes_give_the_bits_of_fresh_ones) {
  const auto [scene, settings] = room(64, 48, 8);
  Settings other = settings;
  other.seed = 7;
  other.sample_end = 5;
  const Execution execution = as_tested({});
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

TEST(Reuse, wavefronts_that_stay_ready_give_the_bits_of_fresh_ones) {
  const auto [scene, settings] = room(64, 48, 8);
  Settings view = settings;
  view.seed = 7, view.max_depth = 3, view.roulette_depth = 2;
  view.sample_begin = 3, view.sample_end = 9;
  view.width = 50, view.height = 70;
  view.crop = {5, 0, 41, 70};
  view.camera.yfov_rad *= 0.7;
  view.camera.world_from_camera = glm::translate(view.camera.world_from_camera, glm::dvec3(0.05, 0.1, 0.02));
  Settings filtered = settings, layered = settings;
  filtered.filter = parse_filter("gaussian");
  layered.aovs = {"albedo", "depth"};
  const Scene other = load_shipped("cornell.gltf");
  const Settings of_other = settings_of(other, 40, 4);
  Execution execution = as_tested({});
  execution.devices = std::to_string(select_devices("cpu").front().index);
  const std::atomic<bool> stop{false};

  DevicePool devices;
  struct Image {
    const Scene* scene;
    Settings settings;
    std::shared_ptr<PackedScene> packed;
    Film expected;
  };
  std::vector<Image> images;
  const auto add = [&](const Scene& of, const Settings& with, std::shared_ptr<PackedScene> packed = nullptr) {
    if (!packed) packed = std::make_shared<PackedScene>(pack_scene(of, Features(of, with), with));
    images.push_back({&of, with, std::move(packed), render(of, with, execution, stop).film});
  };
  add(scene, settings);
  add(scene, view, images.front().packed);
  add(scene, filtered, images.front().packed);
  add(scene, layered);
  add(other, of_other);
  double compile_s = 0;
  for (int round = 0; round < 2; ++round) {
    compile_s = 0;
    for (const Image& image : images) {
      RenderHooks hooks;
      hooks.devices = &devices;
      hooks.devices_stay_ready = true;
      const RenderOutput output = render_packed(image.packed, Features(*image.scene, image.settings), image.settings,
                                                execution, stop, std::move(hooks));
      EXPECT_TRUE(same_film(output.film, image.expected)) << round;
      EXPECT_EQ(output.report.devices.front().samples, output.sample_set.sample_count());
      compile_s += output.report.compile_s;
    }
    EXPECT_EQ(devices.idle_count(), 1U);
  }
  EXPECT_EQ(compile_s, 0) << "four needs of two scenes, all ready after the first round";
  EXPECT_GT(images.front().packed.use_count(), 3) << "kept for the next render";
  // What nobody will render again goes, and what fails is not used again.
  const std::weak_ptr<PackedScene> gone = images.back().packed;
  images.pop_back();
  EXPECT_FALSE(gone.expired());
  devices.close_idle();
  EXPECT_TRUE(gone.expired());
}

TEST(Reuse, a_device_without_times_does_not_serve_where_they_are_wanted) {
  DeviceInfo timed = select_devices("all").front(), untimed = timed;
  untimed.timed = false;
  DevicePool devices;
  const auto address_of = [&](const DeviceInfo& info) { return static_cast<const void*>(&*devices.take(info)); };
  const void* const first = address_of(untimed);
  EXPECT_EQ(address_of(untimed), first);
  EXPECT_FALSE(devices.take(untimed)->info().timed);
  EXPECT_TRUE(devices.take(timed)->info().timed);
  EXPECT_EQ(devices.idle_count(), 2U) << "it was opened anew";
  const DevicePool::Lease taken = devices.take(untimed);
  EXPECT_TRUE(devices.take(untimed)->info().timed) << "one with times serves both";
  EXPECT_EQ(devices.idle_count(), 1U);
}

TEST(Reuse, a_render_without_times_is_the_same_but_for_them) {
  const auto [scene, settings] = room(32, 24, 4);
  const std::atomic<bool> stop{false};
  std::vector<RenderOutput> outputs;
  for (const bool timed : {true, false}) {
    Execution execution = as_tested({});
    execution.timed = timed;
    outputs.push_back(render(scene, settings, execution, stop));
    const DeviceReport& device = outputs.back().report.devices.front();
    double seconds = 0;
    for (const auto& [name, stage] : device.stages) seconds += stage.seconds;
    EXPECT_EQ(seconds > 0, timed);
    EXPECT_GT(device.busy_s, 0) << "the host's clock tells it";
  }
  EXPECT_TRUE(same_film(outputs[0].film, outputs[1].film));
  EXPECT_EQ(outputs[0].report.devices[0].stages.at("film").launches,
            outputs[1].report.devices[0].stages.at("film").launches);
}

TEST(Reuse, a_device_that_is_gone_is_named) {
  DeviceInfo gone = select_devices("all").front();
  gone.index += 1000, gone.name = "toaster";
  const std::string message = message_of<DeviceError>([&] { const Device device(gone); });
  EXPECT_TRUE(contains(message, "'toaster' has disappeared"));
  EXPECT_TRUE(contains(message, "eikon devices"));
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

TEST(Reuse, what_was_made_ready_ahead_gives_the_bits_of_fresh_ones) {
  const auto [first, first_settings] = room(64, 48, 8);
  const Scene second = load_shipped("cornell.gltf");
  const Settings second_settings = settings_of(second, 40, 4);
  const std::atomic<bool> stop{false};
  for (const char* fault : {"", "device:0:gpu"}) {
    setenv("EIKON_FAULT", fault, 1);
    Execution execution = as_tested({});
    execution.devices = std::to_string(select_devices("cpu").front().index);
    DevicePrefetcher devices;
    const auto image = [&](const Scene& scene, const Settings& settings) {
      const Features features(scene, settings);
      return DevicePrefetcher::Image{std::make_shared<PackedScene>(pack_scene(scene, features, settings)), features,
                                     settings, execution};
    };
    const auto render_on = [&](DevicePrefetcher::Turn& turn, const DevicePrefetcher::Image& of) {
      RenderHooks hooks;
      hooks.devices = &turn.pool();
      hooks.devices_stay_ready = true;
      hooks.under_way = [&] { turn.under_way(); };
      return render_packed(of.packed, of.features, of.settings, execution, stop, hooks);
    };
    const DevicePrefetcher::Image one = image(first, first_settings), other = image(second, second_settings);
    const auto first_turn = devices.turn(one, stop);
    EXPECT_EQ(first_turn->pool().idle_count(), 0U) << "the first has nobody to wait for";
    const RenderOutput first_output = render_on(*first_turn, one);
    const auto second_turn = devices.turn(other, stop);
    EXPECT_EQ(second_turn->pool().idle_count(), 1U) << "it was opened ahead";
    const RenderOutput second_output = render_on(*second_turn, other);
    if (*fault != '\0') {
      EXPECT_EQ(second_output.report.upload_s, 0) << "it was uploaded ahead";
    }
    // What is ready on the devices of the turn before is not made ready once more.
    const auto third_turn = devices.turn(other, stop);
    EXPECT_EQ(third_turn->pool().idle_count(), 1U);
    EXPECT_TRUE(same_film(render_on(*third_turn, other).film, second_output.film));
    const auto fourth_turn = devices.turn(one, stop);
    const RenderOutput again = render_on(*fourth_turn, one);
    EXPECT_EQ(again.report.upload_s, 0) << "it was there";
    setenv("EIKON_FAULT", "", 1);
    EXPECT_TRUE(same_film(first_output.film, render(first, first_settings, execution, stop).film));
    EXPECT_TRUE(same_film(second_output.film, render(second, second_settings, execution, stop).film));
    EXPECT_TRUE(same_film(again.film, first_output.film));
  }
  unsetenv("EIKON_FAULT");
}

TEST(Reuse, nothing_is_made_ready_ahead_beyond_a_limit) {
  const auto [scene, settings] = room(32, 24, 2);
  const Scene other = load_shipped("cornell.gltf");
  const std::atomic<bool> stop{false};
  Execution limited;
  limited.devices = std::to_string(select_devices("cpu").front().index);
  limited.threads = 1;
  Execution little = limited;
  little.threads = 0, little.memory_bytes = std::uint64_t{1} << 30;
  for (const Execution& execution : {limited, little}) {
    DevicePrefetcher devices;
    const auto turn_of = [&, &settings = settings](const Scene& of) {
      const Features features(of, settings);
      return devices.turn(
          {std::make_shared<PackedScene>(pack_scene(of, features, settings)), features, settings, execution}, stop);
    };
    (void)turn_of(scene);
    EXPECT_EQ(turn_of(other)->pool().idle_count(), 0U);
  }
}

}  // namespace
}  // namespace eikon::test
