// SPDX-License-Identifier: Apache-2.0
// The state of a Wavefront, and the steps in which it renders a unit. Only wavefront.cpp includes
// this file.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "device/kernel_sources.h"
#include "pack/frame.h"
#include "wavefront/buffers.h"
#include "wavefront/photons/photon_stage.h"
#include "wavefront/stages/depth_stages.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/stage_sampler.h"
#include "wavefront/unit_in_flight.h"
#include "wavefront/wavefront.h"

namespace eikon {

// The values with which counters on the device begin: of paths that work-items have taken from the
// unit (next_path of kernel `paths`), and of sums that did not fit the packed form (word 0 of
// film_packed, shared/packed_sums.h).
inline constexpr std::uint32_t kNoPathTaken = 0, kNoSumUnpacked = 0;

struct Wavefront::Impl {
  Device& device;
  const PackedScene* scene;
  WavefrontConfig config;
  PathStateLayout state;
  Frame frame;
  std::vector<float> filter, camera_poses;
  WorkBufferSizes sizes;
  LightPathPlan light_paths;
  bool has_light_stages = false;    // the program has the stages of light paths
  bool light_paths_enabled = true;  // units have light paths, if the program can trace them
  LightStages lights;
  PhotonStage photons;
  Mattes mattes;
  Arguments arguments;
  StageKernels stages;
  Kernel paths;  // runs all stages; if WavefrontConfig::fused
  WorkBuffers work;
  ArithmeticClass arithmetic;
  ProgramOptions compiled;  // options with which the program was compiled
  std::vector<std::string> sampled_stages;
  std::string formula_code;
  // Kept alive here, because the buffers of a CPU device may be the memory of the table
  // (Device::share).
  std::shared_ptr<const GuideTable> guide;
  LightAimBuffers light_aim;
  std::shared_ptr<const void> logged, radiance;    // memory that the last PathLog refers to
  std::uint64_t scene_bytes = 0, texel_bytes = 0;  // scene_bytes: without the texels
  double upload_s = 0;

  std::array<UnitInFlight, 2> in_flight;
  std::uint64_t begun = 0, launched = 0, finished = 0;  // units for which begin(), launch_rest(), finish() were called
  RayCounters counters;
  DepthStages depths;  // if each stage has a launch of its own
  Trace* timeline;
  std::unique_ptr<StageSampler> sampler;  // null unless one launch runs all stages and cannot time them (ticks.h)

  // Commands of the device's queue may still use the memory that is freed here, as after an error.
  ~Impl() { device.drain(); }

  Impl(Device& on, const PackedScene& packed, const Features& features, const Settings& settings,
       const Execution& execution)
      : device(on),
        scene(&packed),
        config(configure(on.info(), execution)),
        counters(on, config, features, execution.trace.get()),
        depths(on, config, stages, counters),
        timeline(execution.trace.get()) {
    for (std::size_t i = 0; i < in_flight.size(); ++i) in_flight[i].index = i;
    state = path_state_layout(features, config.chunked);
    frame = pack_frame(packed, settings);
    filter = filter_table(settings.filter);
    camera_poses = camera_pose_words(packed, settings);
    mattes = features.mattes();
    sizes = work_buffer_sizes(config, features, settings);
    compile(features, execution);
    begin_image(settings);
    guide = settings.guide;
    light_aim.aim = settings.light_aim;
    try {
      upload(execution.track);
      bind();
      warm_up(execution.track);
    } catch (...) {
      device.drain();
      throw;
    }
  }

  void begin_image(const Settings& settings) {
    light_paths_enabled = true;
    light_paths = {frame.light_path_count, settings.crop};
    photons.restart(photon_plan(settings), frame);
  }

  void restart(const Settings& settings, const Execution& execution) {
    const Frame before = std::exchange(frame, pack_frame(*scene, settings));
    frame.film_stride = before.film_stride;
    begin_image(settings);
    timeline = execution.trace.get();
    counters.restart(timeline);
    upload_s = 0;
    if (replace_camera(device, *scene, settings, camera_poses, arguments)) bind();
    if (settings.guide != nullptr && settings.guide != guide) set_guide(settings.guide);
    if (has_light_stages && settings.light_aim != light_aim.aim) set_light_aim(settings.light_aim);
  }

  [[nodiscard]] bool fits(const PackedScene& packed, const Features& features, const Execution& execution) const {
    const WavefrontConfig wanted = configure(device.info(), execution);
    if (sampler || features.formula_code() != formula_code || features.mattes().ids.size() != mattes.ids.size())
      return false;
    return program_options(device.info(), wanted, features, accel_of(packed, wanted), execution).defines ==
           compiled.defines;
  }

  void change_scene(const PackedScene& packed, const Features& features, const Settings& settings,
                    const Execution& execution) {
    const TraceScope uploading(execution.trace.get(), execution.track, "upload");
    const double begin = host_seconds();
    device.finish();
    const PackedScene& before = *std::exchange(scene, &packed);
    mattes = features.mattes();
    camera_poses = camera_pose_words(packed, settings);
    scene_bytes = upload_scene(device, packed, accel_of(packed, config), filter, camera_poses, arguments);
    if (!have_same_texels(before, packed)) texel_bytes = upload_texels(device, packed, arguments);
    light_aim = {};
    bind();
    device.finish();
    restart(settings, execution);
    upload_s = host_seconds() - begin;
  }

  void set_guide(std::shared_ptr<const GuideTable> table) {
    device.finish();
    const auto before = std::exchange(guide, std::move(table));
    eikon::set_guide(frame, *guide);
    upload_guide(device, *guide, arguments);
    bind();
  }

  void set_light_aim(std::shared_ptr<const LightAim> aim) {
    device.finish();
    const auto before = std::exchange(light_aim, LightAimBuffers{std::move(aim), {}});
    upload_light_aim(device, *scene, light_aim, arguments);
    bind();
  }

  void compile(const Features& features, const Execution& execution) {
    const TraceScope compiling(timeline, execution.track, "compile");
    const WavefrontProgram source(device.info(), config, *scene, features, execution);
    const Program program = device.build(source.text, source.options);
    has_light_stages = source.has("light_generate") || source.has("light_paths");
    if (has_light_stages) lights = LightStages(device, program, config, arguments);
    if (features.has(Feature::merging)) photons = PhotonStage(device, arguments);
    arithmetic = trusted_arithmetic(device, program);
    std::vector<std::string> own_launch = source.stages;
    std::erase_if(own_launch, [](const std::string& stage) {
      return stage == "film" || stage == "pack_sums" || stage == "paths" || stage == "light_paths";
    });
    stages = StageKernels(device, config, program, own_launch);
    if (config.fused) paths = program.kernel("paths");
    in_flight[0].film = program.kernel("film");
    in_flight[1].film = device.info().cpu ? in_flight[0].film : program.kernel("film");
    for (UnitInFlight& current : in_flight)
      if (!config.chunked) current.pack_sums = program.kernel("pack_sums");
    compiled = source.options;
    WavefrontConfig unfused = config;
    unfused.fused = false;
#define EK_PATH_STAGE(name) \
  if (needs_stage(unfused, features, #name)) sampled_stages.emplace_back(#name);
#include "shared/stages.def"
    formula_code = source.formula_code;
  }

  /// Makes the sampler if kernel `paths` has no counter for its stages.
  void make_sampler() {
    WorkerTally tally;
    device.read(work.tallies, &tally, sizeof tally);
    if ((tally.begin[0] | tally.begin[1]) != 0) return;
    std::vector<std::string> files;
    for (const std::string& stage : sampled_stages) files.push_back("stages/" + stage + ".cl");
    const Program program = device.build(kernel_text(files) + formula_code, compiled);
    sampler = std::make_unique<StageSampler>(device, program, sampled_stages, arguments, config);
  }

  void upload(Trace::Track track) {
    const TraceScope uploading(timeline, track, "upload");
    const double begin = host_seconds();
    scene_bytes = upload_scene(device, *scene, accel_of(*scene, config), filter, camera_poses, arguments);
    texel_bytes = upload_texels(device, *scene, arguments);
    if (guide != nullptr) upload_guide(device, *guide, arguments);
    if (has_light_stages && light_aim.aim != nullptr) upload_light_aim(device, *scene, light_aim, arguments);
    work = WorkBuffers(device, config, sizes, arguments);
    frame.film_stride = config.capacity() + EK_PAD;
    for (UnitInFlight& current : in_flight) current.tallies.resize(config.workers);
    arguments.set("depth", 1U);
    device.finish();
    upload_s = host_seconds() - begin;
  }

  void bind() {
    stages.bind(arguments);
    if (config.fused) paths.bind(arguments);
    lights.bind(arguments, stages);
    if (sampler) sampler->bind(arguments);
    for (std::size_t i = 0; i < in_flight.size(); ++i) {
      Arguments own = arguments;
      own.set("film_sums", work.sums[i]);
      own.set("film_rejected", work.rejected[i]);
      in_flight[i].film.bind(own);
      if (config.chunked) continue;
      own.set("film_packed", work.packed[i]);
      in_flight[i].pack_sums.bind(own);
    }
  }

  /// Launches every kernel once on a unit without paths. Some drivers make machine code at the
  /// first launch, and that time counts as compiling.
  void warm_up(Trace::Track track) {
    const TraceScope warming(timeline, track, "warm up");
    Profiler& profiler = device.profiler();
    const double begin = host_seconds(), compiled_s = profiler.compile_s;
    device.write(work.frame, &frame, sizeof frame);
    stages.warm_up();
    if (config.fused) device.run(paths, 1, 1);
    for (const UnitInFlight& current : in_flight) {
      device.run(current.film, 1, config.chunked ? 1 : kWorkGroup);
      if (!config.chunked) device.run(current.pack_sums, 1, kWorkGroup);
    }
    lights.warm_up();
    device.finish();
    if (config.fused && device.info().timed) make_sampler();
    profiler.compile_s = compiled_s + (host_seconds() - begin);  // a driver may compile behind the launch
    profiler.restart();
  }

  /// Launches the film stage, whose work-items own pixels instead of paths, and reads its sums
  /// back.
  void run_film(UnitInFlight& current) {
    const std::uint32_t pixel_count = current.frame.pixel_count;
    const bool packs = !config.chunked;
    if (config.chunked) {
      device.run(current.film, divide_up(pixel_count, EK_FILM_PIXELS), 1, current.frame.path_count);
    } else {
      device.write_later(work.packed[current.index], &kNoSumUnpacked, sizeof kNoSumUnpacked);
      device.run(current.film, divide_up(pixel_count, kWorkGroup), kWorkGroup, current.frame.path_count);
      device.run(current.pack_sums, divide_up(pixel_count, kWorkGroup), kWorkGroup);
    }
    current.resize(device, sizes.film, packs);
    const std::size_t path_count = current.frame.path_count;
    // This read is in the queue because the next unit clears the buffer. The host waits for the
    // last of the large reads.
    device.read_later(work.diagnostics, current.diagnostics_words.words().data(), sizeof current.diagnostics);
    for (std::size_t m = 0; m < sizes.film.mattes; ++m)
      device.read_later(work.film_slots, &current.matte_numbers[m * path_count], 4 * path_count,
                        4 * (sizes.film.channels + m) * std::size_t{frame.film_stride});
    if (packs) {
      current.summed =
          device.read_beside(work.packed[current.index], current.packed.words().data(), current.packed.size_bytes());
    } else {
      device.read_beside(work.rejected[current.index], current.rejected.data(), 4 * current.rejected.size());
      current.summed = device.read_beside(work.sums[current.index], current.sums.data(), 4 * current.sums.size());
    }
    device.flush();
  }

  /// Waits for what the film stage left, and fetches what is seldom needed.
  void collect_sums(UnitInFlight& current) {
    device.wait(current.summed);
    std::memcpy(&current.diagnostics, current.diagnostics_words.words().data(), sizeof current.diagnostics);
    if (config.chunked) return;
    const auto fetch = [&](const Buffer& from, std::vector<std::uint32_t>& to) {
      device.wait(device.read_beside(from, to.data(), 4 * to.size()));
    };
    if (current.diagnostics.nonfinite + current.diagnostics.saturated > 0)
      fetch(work.rejected[current.index], current.rejected);
    else
      std::ranges::fill(current.rejected, 0U);
    if (current.packed.words()[0] == 0) return;  // all sums fit
    current.resize(device, sizes.film, false);
    fetch(work.sums[current.index], current.sums);
  }

  /// Renders a unit in one launch.
  void launch_fused(UnitInFlight& current) {
    device.write_later(work.next_path, &kNoPathTaken, sizeof kNoPathTaken);
    device.run(paths, config.workers, 1, current.frame.path_count);
    current.tallied =
        device.read_later(work.tallies, current.tallies.data(), current.tallies.size() * sizeof(WorkerTally));
    run_film(current);
  }
  /// Waits for the launch, and counts the rays that it traced.
  void settle_fused(UnitInFlight& current) {
    device.wait(current.tallied);
    current.rays = counters.add_launch(current.frame.path_count, current.tallies,
                                       sampler ? sampler->shares() : stage_shares(current.tallies));
  }

  void begin(const WorkUnit& unit) {
    if (begun - finished == in_flight.size() || (!config.fused && begun != launched))
      throw InternalError("a unit begins before there is room for it");
    UnitInFlight& current = in_flight[begun % in_flight.size()];
    current.unit = unit;
    const std::vector<std::uint32_t> pixels = unit_pixels(unit.block);
    current.pixels.resize(device, pixels.size());
    std::ranges::copy(pixels, current.pixels.words().begin());
    current.rays = {};
    if (unit.path_count() > config.capacity() || current.pixels.size_bytes() > work.pixels.size_bytes())
      throw InternalError(
          fmt::format("a unit of {} paths exceeds the capacity of {}", unit.path_count(), config.capacity()));
    current.photon_rays = {};
    if (photons.exists() && photons.prepare(lights, current.index, unit, frame, arguments, current.photon_rays)) bind();
    current.frame = unit_frame(frame, unit.sample_begin, unit.sample_end, std::uint32_t(pixels.size()));
    device.begin_unit(current.frame.path_count);
    if (sampler) sampler->before(current.frame, pixels);
    device.write_later(work.frame, &current.frame, sizeof current.frame);
    device.write_later(work.pixels, current.pixels.words().data(), current.pixels.size_bytes());
    device.write_later(work.diagnostics, &current.no_diagnostics, sizeof current.no_diagnostics);
    ++begun;
    if (config.fused) {
      launch_fused(current);
      begin_lights(current);
      launched = begun;
    } else {
      current.rays.camera = current.frame.path_count;
      depths.begin(current.frame, work.counts);
    }
  }

  void begin_lights(UnitInFlight& current) {
    const LightPathPlan plan{light_paths_enabled ? light_paths.count : 0, light_paths.window};
    if (has_light_stages) lights.begin(current.lights, current.index, current.unit, plan, frame);
  }

  void launch_rest() {
    if (launched == begun) return;
    UnitInFlight& current = in_flight[launched % in_flight.size()];
    current.rays += depths.launch_rest();
    run_film(current);
    depths.settle();
    if (!depths.replays_one_path) begin_lights(current);
    ++launched;
  }

  UnitResult finish() {
    if (finished == begun) throw InternalError("no unit was begun");
    if (finished == launched) launch_rest();
    UnitInFlight& current = in_flight[finished % in_flight.size()];
    ++finished;
    if (config.fused) settle_fused(current);
    collect_sums(current);
    if (has_light_stages) lights.finish(current.lights, current.index);
    return current.result(mattes);
  }

  /// The unit that finished last.
  [[nodiscard]] UnitInFlight& last_unit() { return in_flight[(finished - 1) % in_flight.size()]; }
  /// A word of the state of the unit's first path, by the name of its field in path_state.def.
  [[nodiscard]] std::uint32_t path_word(const char* field, std::uint32_t word = 0) {
    std::uint32_t value = 0;
    device.read(work.state, &value, sizeof value,
                4 * std::size_t{state.field.at(field) + word} * (config.chunk + EK_PAD));
    return value;
  }
};

}  // namespace eikon
