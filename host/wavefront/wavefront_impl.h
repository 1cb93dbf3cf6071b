// SPDX-License-Identifier: Apache-2.0
// The state of a Wavefront, and the steps in which it renders a unit. Only wavefront.cpp includes this file.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "device/kernel_sources.h"
#include "pack/frame.h"
#include "wavefront/buffers.h"
#include "wavefront/stage_sampler.h"
#include "wavefront/light_stages.h"
#include "wavefront/unit_slot.h"
#include "wavefront/wavefront.h"

namespace eikon {

inline constexpr std::uint32_t kNoPaths = 0;
inline std::uint32_t divide_up(std::uint64_t a, std::uint64_t b) { return std::uint32_t((a + b - 1) / b); }

struct Wavefront::Impl {
  /// Counts of a depth that are being read back.
  struct DepthCounts {
    std::uint32_t depth = 0;
    std::vector<std::uint32_t> counts;
    Ticket ticket;
  };

  Device& device;
  const PackedScene* scene;
  WavefrontConfig config;
  PathStateLayout state;
  Frame frame;
  std::vector<float> filter, camera_poses;
  FilmShape film_shape;
  bool logs = false;  // feature path_log
  LightPathPlan light_paths;
  bool traces_lights = false, lights_on = true;  // the program has the stages of light paths; units have them
  LightStages lights;
  Mattes mattes;
  Arguments arguments;
  std::map<std::string, Kernel> kernels;
  WorkBuffers work;
  ArithmeticClass arithmetic;
  ProgramOptions compiled;  // of the program
  std::vector<std::string> sampled_stages;
  std::string formula_code;
  std::shared_ptr<const GuideTable> guide;      // device buffers may be its memory
  std::vector<std::uint32_t> logged, radiance;  // of PathLog
  std::uint64_t scene_bytes = 0, texel_bytes = 0;  // scene_bytes: without the texels
  double upload_s = 0;

  using Slot = UnitSlot;
  std::array<Slot, 2> slots;
  std::uint64_t begun = 0, driven = 0, finished = 0;         // units so far
  std::function<void(std::uint32_t depth)> after_intersect;  // of replay; then the device does not run ahead
  RayCounters counters;
  Trace* timeline;
  std::unique_ptr<StageSampler> sampler;  // if one launch runs all stages, and has no counter for them
  std::deque<DepthCounts> under_way;      // a member, so that it outlives the transfers after an error

  // Work under way uses the memory that is freed here, after an error too.
  ~Impl() { device.drain(); }

  Impl(Device& on, const PackedScene& packed, const Features& features, const Settings& settings,
       const Execution& execution)
      : device(on),
        scene(&packed),
        config(configure(on.info(), execution)),
        counters(on, config, features, execution.trace.get()),
        timeline(execution.trace.get()) {
    state = path_state_layout(features, config.chunked);
    frame = pack_frame(packed, settings);
    light_paths = {frame.light_path_count, settings.crop};
    filter = filter_table(settings.filter);
    camera_poses = camera_pose_words(settings);
    mattes = features.mattes();
    film_shape = {.replicates = 1U << settings.replicate_bits,
                  .channels = std::uint32_t(features.film_channels().size()),
                  .mattes = std::uint32_t(mattes.ids.size())};
    compile(features, execution);
    logs = features.has(Feature::path_log);
    guide = settings.guide;
    try {
      upload(execution.track);
      bind();
      warm_up(execution.track);
    } catch (...) {
      device.drain();
      throw;
    }
  }

  void restart(const Settings& settings, const Execution& execution) {
    const Frame before = std::exchange(frame, pack_frame(*scene, settings));
    frame.film_stride = before.film_stride;
    light_paths = {frame.light_path_count, settings.crop};
    timeline = execution.trace.get();
    counters.restart(timeline);
    upload_s = 0;
    if (replace_camera(device, settings, camera_poses, arguments)) bind();
    if (settings.guide != nullptr && settings.guide != guide) set_guide(settings.guide);
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
    camera_poses = camera_pose_words(settings);
    scene_bytes = upload_scene(device, packed, accel_of(packed, config), filter, camera_poses, arguments);
    if (!have_same_texels(before, packed)) texel_bytes = upload_texels(device, packed, arguments);
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

  void compile(const Features& features, const Execution& execution) {
    const TraceScope compiling(timeline, execution.track, "compile");
    const WavefrontProgram source(device.info(), config, *scene, features, execution);
    const Program program = device.build(source.text, source.options);
    traces_lights = source.has("light_generate") || source.has("light_paths");
    if (traces_lights) lights = LightStages(device, program, config, arguments);
    arithmetic = trusted_arithmetic(device, program);
    for (const std::string& stage : source.stages)
      if (stage != "film" && stage != "light_paths") kernels[stage] = program.kernel(stage);
    slots[0].film = program.kernel("film");
    slots[1].film = device.info().cpu ? slots[0].film : program.kernel("film");
    compiled = source.options;
    WavefrontConfig unfused = config;
    unfused.fused = false;
    for (const char* stage : {"generate", "intersect", "miss", "shade", "shadow"})
      if (needs_stage(unfused, features, stage)) sampled_stages.push_back(stage);
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
    const WorkBufferSizes plan{.film = film_shape, .state_words = state.words, .logs = logs};
    if (guide != nullptr) upload_guide(device, *guide, arguments);
    work = WorkBuffers(device, config, plan, arguments);
    frame.film_stride = config.capacity() + EK_PAD;
    for (Slot& slot : slots) slot.tallies.resize(config.workers);
    arguments.set("depth", 1U);
    device.finish();
    upload_s = host_seconds() - begin;
  }

  void bind() {
    for (auto& [name, kernel] : kernels) kernel.bind(arguments);
    lights.bind(arguments, kernels);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      Arguments own = arguments;
      own.set("film_sums", work.sums[i]);
      own.set("film_rejected", work.rejected[i]);
      slots[i].film.bind(own);
    }
  }

  /// Launches every kernel once on a unit without paths. Some drivers make machine code at the
  /// first launch, and that time counts as compiling.
  void warm_up(Trace::Track track) {
    const TraceScope warming(timeline, track, "warm up");
    Profiler& profiler = device.profiler();
    const double begin = host_seconds(), compiled_s = profiler.compile_s;
    device.write(work.frame, &frame, sizeof frame);
    for (const auto& [name, kernel] : kernels) device.run(kernel, 1, config.chunked ? 1 : kWorkGroup);
    for (const Slot& slot : slots) device.run(slot.film, 1, config.chunked ? 1 : kWorkGroup);
    lights.warm_up();
    device.finish();
    if (config.fused) make_sampler();
    profiler.compile_s = compiled_s + (host_seconds() - begin);  // a driver may compile behind the launch
    profiler.restart();
  }

  /// Launches a stage over the paths of a unit, if this scene needs the stage. There is a work-item
  /// per chunk, or one for each of `most` queue entries.
  void run_stage(const char* name, std::uint32_t depth, std::uint64_t most, const Slot& slot) {
    const auto found = kernels.find(name);
    if (found == kernels.end()) return;
    found->second.set("depth", depth);
    if (config.chunked)
      device.run(found->second, used_chunks(slot), 1);
    else
      device.run(found->second, divide_up(most, kWorkGroup), kWorkGroup);
  }
  [[nodiscard]] std::uint32_t used_chunks(const Slot& slot) const {
    return config.chunked ? divide_up(slot.frame.path_count, config.chunk) : 1;
  }
  /// Launches the film stage, whose work-items own pixels instead of paths, and reads its sums
  /// back.
  void run_film(Slot& slot) {
    const auto which = std::size_t(&slot - slots.data());
    const std::uint32_t pixel_count = slot.frame.pixel_count;
    if (config.chunked)
      device.run(slot.film, divide_up(pixel_count, EK_FILM_PIXELS), 1, slot.frame.path_count);
    else
      device.run(slot.film, divide_up(pixel_count, kWorkGroup), kWorkGroup, slot.frame.path_count);
    slot.resize(film_shape);
    const std::size_t path_count = slot.frame.path_count;
    // This read is in the queue because the next unit clears the buffer. The host waits for the
    // last of the large reads.
    device.read_later(work.diagnostics, &slot.diagnostics, sizeof slot.diagnostics);
    for (std::size_t m = 0; m < film_shape.mattes; ++m)
      device.read_later(work.film_slots, &slot.met[m * path_count], 4 * path_count,
                        4 * (film_shape.channels + m) * std::size_t{frame.film_stride});
    device.read_beside(work.rejected[which], slot.rejected.data(), 4 * slot.rejected.size());
    slot.summed = device.read_beside(work.sums[which], slot.sums.data(), 4 * slot.sums.size());
    device.flush();
  }

  /// Renders a unit in one launch.
  void launch_fused(Slot& slot) {
    device.write_later(work.next_path, &kNoPaths, sizeof kNoPaths);
    device.run(kernels.at("paths"), config.workers, 1, slot.frame.path_count);
    slot.tallied = device.read_later(work.tallies, slot.tallies.data(), slot.tallies.size() * sizeof(WorkerTally));
    run_film(slot);
  }
  /// Waits for the launch, and counts the rays that it traced.
  void settle_fused(Slot& slot) {
    device.wait(slot.tallied);
    slot.rays = counters.add_launch(slot.frame.path_count, slot.tallies,
                                    sampler ? sampler->shares() : stage_shares(slot.tallies));
  }

  /// Launches the stages of a depth. active: most paths at that depth
  void launch_depth(Slot& slot, std::uint32_t depth, std::uint64_t active) {
    counters.add_depth(depth, std::uint64_t{divide_up(active, kWorkGroup)} * kWorkGroup);
    run_stage("intersect", depth, active, slot);
    if (after_intersect) after_intersect(depth);
    run_stage("miss", depth, active, slot);
    run_stage("shade", depth, active, slot);
    run_stage("compact", depth, active, slot);
    DepthCounts& at = under_way.emplace_back();
    at.depth = depth;
    at.counts.resize(4 * std::size_t{used_chunks(slot)});
    at.ticket = device.read_later(work.counts, at.counts.data(), 4 * at.counts.size());
    run_stage("shadow", depth, active, slot);
    device.flush();
  }

  /// Launches the first depth of a unit, stage by stage.
  void launch_first(Slot& slot) {
    const std::uint64_t paths = slot.frame.path_count;
    slot.rays.camera = paths;
    counters.begin_unit(paths);
    run_stage("generate", 1, paths, slot);
    launch_depth(slot, 1, paths);
  }

  /// Launches the other depths. The host looks at the counts of a depth while the next one is under
  /// way. This costs one round of empty launches at the end of a unit.
  void launch_rest(Slot& slot) {
    const std::size_t ahead = after_intersect ? 0 : 1;
    std::uint64_t active = slot.frame.path_count;  // at least as many as go on
    for (std::uint32_t depth = 2; active > 0; ++depth) {
      while (active > 0 && under_way.size() > ahead) {
        active = settle(slot, under_way.front());
        under_way.pop_front();
      }
      if (active > 0) launch_depth(slot, depth, active);
    }
    run_film(slot);
    // The counts left are zero, but their reads write to memory that is freed here.
    for (const DepthCounts& at : under_way) device.wait(at.ticket);
    under_way.clear();
  }

  /// Waits for the counts of a depth. Returns the number of paths that go on.
  std::uint64_t settle(Slot& slot, const DepthCounts& at) {
    device.wait(at.ticket);
    const RayCounts on = counters.end_depth(at.depth, std::span(at.counts).first(4 * std::size_t{used_chunks(slot)}),
                                            slot.frame.path_count);
    slot.rays += on;
    return on.scattered;
  }

  void begin(const WorkUnit& unit) {
    if (begun - finished == slots.size() || (!config.fused && begun != driven))
      throw InternalError("a unit begins before there is room for it");
    Slot& slot = slots[begun % slots.size()];
    slot.unit = unit;
    slot.pixels = unit_pixels(unit.block);
    slot.rays = {};
    if (unit.path_count() > config.capacity() || 4 * slot.pixels.size() > work.pixels.size_bytes())
      throw InternalError(
          fmt::format("a unit of {} paths exceeds the pool of {}", unit.path_count(), config.capacity()));
    slot.frame = unit_frame(frame, unit.sample_begin, unit.sample_end, std::uint32_t(slot.pixels.size()));
    device.begin_unit(slot.frame.path_count);
    if (sampler) sampler->before(slot.frame, slot.pixels);
    device.write_later(work.frame, &slot.frame, sizeof slot.frame);
    device.write_later(work.pixels, slot.pixels.data(), 4 * slot.pixels.size());
    device.write_later(work.diagnostics, &slot.nothing, sizeof slot.nothing);
    ++begun;
    if (config.fused) {
      launch_fused(slot);
      begin_lights(slot);
      driven = begun;
    } else {
      launch_first(slot);
    }
  }

  void begin_lights(Slot& slot) {
    const LightPathPlan plan{lights_on ? light_paths.count : 0, light_paths.window};
    if (traces_lights) lights.begin(slot.lights, std::size_t(&slot - slots.data()), slot.unit, plan, frame);
  }

  void drive() {
    if (driven == begun) return;
    launch_rest(slots[driven % slots.size()]);
    if (!after_intersect) begin_lights(slots[driven % slots.size()]);
    ++driven;
  }

  UnitResult finish() {
    if (finished == begun) throw InternalError("no unit was begun");
    if (finished == driven) drive();
    Slot& slot = slots[finished % slots.size()];
    ++finished;
    if (config.fused) settle_fused(slot);
    device.wait(slot.summed);
    if (traces_lights) lights.finish(slot.lights, std::size_t(&slot - slots.data()));
    return slot.result(mattes);
  }

  [[nodiscard]] Slot& last_slot() { return slots[(finished - 1) % slots.size()]; }  // of the unit that finished last
  [[nodiscard]] std::uint32_t path_word(const char* field, std::uint32_t word = 0) {
    std::uint32_t value = 0;
    device.read(work.state, &value, sizeof value,
                4 * std::size_t{state.field.at(field) + word} * (config.chunk + EK_PAD));
    return value;
  }
};

}  // namespace eikon
