// SPDX-License-Identifier: Apache-2.0
#include "wavefront/wavefront.h"

#include <algorithm>
#include <array>
#include <bit>
#include <deque>
#include <fmt/format.h>
#include <utility>

#include "core/error.h"
#include "device/kernel_sources.h"
#include "pack/frame.h"
#include "wavefront/scene_buffers.h"
#include "wavefront/timing/stage_sampler.h"
#include "wavefront/timing/stage_shares.h"
#include "wavefront/wavefront_memory.h"
#include "wavefront/wavefront_program.h"

namespace eikon {
namespace {

constexpr std::uint32_t kGroup = 64;  // work-items of a work-group on GPU devices
constexpr std::uint32_t kNoPaths = 0;

std::uint32_t divide_up(std::uint64_t a, std::uint64_t b) { return std::uint32_t((a + b - 1) / b); }

}  // namespace

struct Wavefront::Impl {
  /// Counts of a depth on their way to the host.
  struct DepthCounts {
    std::uint32_t depth = 0;
    std::vector<std::uint32_t> counts;
    Ticket ticket;
  };

  Device& device;
  const PackedScene& scene;
  WavefrontConfig config;
  PathStateLayout state;
  Frame frame;
  std::vector<float> filter;
  FilmShape film_shape;
  std::uint32_t light_samples;
  Mattes mattes;
  bool has_environment, has_shadow;
  Arguments arguments;
  std::map<std::string, Kernel> kernels;
  WavefrontMemory memory;
  ArithmeticClass arithmetic;
  ProgramOptions sampled_options;
  std::string formula_code;
  std::uint64_t scene_bytes = 0;
  double upload_s = 0;

  /// Of a unit under way: what is on its way to the device, and back. Two at a time, so that the device always has the next one.
  struct Slot {
    WorkUnit unit;
    Frame frame;
    Diagnostics nothing{}, diagnostics{};
    std::vector<std::uint32_t> pixels, sums, rejected, met;
    std::vector<WorkerTally> tallies;
    RayCounts rays;
    Kernel film;
    Ticket tallied, summed;
  };
  std::array<Slot, 2> slots;
  std::uint64_t begun = 0, driven = 0, finished = 0;         // units so far
  std::function<void(std::uint32_t depth)> after_intersect;  // for replay; the device is not let run ahead then
  RayCensus census;
  Trace* timeline;
  std::unique_ptr<StageSampler> sampler;  // where one launch runs all stages, and has no counter to tell them apart
  std::deque<DepthCounts> under_way;      // a member, so that it outlives the transfers when something throws

  // Work under way reads and writes what is freed below; after an error too.
  ~Impl() { device.drain(); }

  Impl(Device& on, const PackedScene& packed, const Features& features, const Settings& settings,
       const Execution& execution)
      : device(on),
        scene(packed),
        config(configure(on.info(), execution)),
        census(on, config, features, execution.trace.get()),
        timeline(execution.trace.get()) {
    state = path_state_layout(features, config.chunked);
    frame = pack_frame(packed, settings);
    filter = filter_table(settings.filter);
    light_samples = features.light_samples();
    mattes = features.mattes();
    film_shape = {.replicates = 1U << settings.replicate_bits,
                  .channels = std::uint32_t(features.film_channels().size()),
                  .mattes = std::uint32_t(mattes.ids.size())};
    has_environment = features.has("environment") || features.has("environment_map");
    has_shadow = features.has("next_event");
    const auto scope = [&](const char* name) { return TraceScope(timeline, execution.track, name); };
    {
      const TraceScope compiling = scope("compile");
      compile(features, execution);
    }
    try {
      TraceScope uploading = scope("upload");
      upload();
      uploading.end();
      const TraceScope warming = scope("warm up");
      bind();
      warm_up();
    } catch (...) {
      device.drain();
      throw;
    }
  }

  void restart(const Settings& settings, const Execution& execution) {
    const Frame before = std::exchange(frame, pack_frame(scene, settings));
    frame.film_stride = before.film_stride;
    timeline = execution.trace.get();
    census.restart(timeline);
    upload_s = 0;
  }

  void compile(const Features& features, const Execution& execution) {
    const WavefrontProgram source(device.info(), config, scene, features, execution);
    const Program program = device.build(source.text, source.options);
    arithmetic = trusted_arithmetic(device, program);
    for (const std::string& stage : source.stages)
      if (stage != "film") kernels[stage] = program.kernel(stage);
    slots[0].film = program.kernel("film");
    slots[1].film = device.info().cpu ? slots[0].film : program.kernel("film");
    sampled_options = source.options;
    formula_code = source.formula_code;
  }

  /// Where kernel `paths` cannot tell how its stages share it.
  void make_sampler() {
    WorkerTally tally;
    device.read(memory.tallies, &tally, sizeof tally);
    if ((tally.begin[0] | tally.begin[1]) != 0) return;
    std::vector<std::string> stages, files;
    for (const char* stage : {"generate", "intersect", "miss", "shade", "shadow"}) {
      const std::string name = stage;
      if ((name == "miss" && !has_environment) || (name == "shadow" && !has_shadow)) continue;
      stages.push_back(name), files.push_back("stages/" + name + ".cl");
    }
    const Program program = device.build(kernel_text(files) + formula_code, sampled_options);
    sampler = std::make_unique<StageSampler>(device, program, stages, arguments, config);
  }

  void upload() {
    const double begin = host_seconds();
    scene_bytes = upload_scene(device, scene, accel_of(scene, config), filter, arguments);
    const MemoryPlan plan{.film = film_shape, .state_words = state.words, .light_samples = light_samples};
    memory = WavefrontMemory(device, config, plan, arguments);
    frame.film_stride = config.capacity() + EK_PAD;
    for (Slot& slot : slots) slot.tallies.resize(config.workers);
    arguments.set("depth", 1U);
    device.finish();
    upload_s = host_seconds() - begin;
  }

  void bind() {
    for (auto& [name, kernel] : kernels) kernel.bind(arguments);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      Arguments own = arguments;
      own.set("film_sums", memory.sums[i]);
      own.set("film_rejected", memory.rejected[i]);
      slots[i].film.bind(own);
    }
  }

  /// Launches every kernel once on a unit without paths: some drivers make machine code at the first launch, and that is
  /// compiling, not rendering.
  void warm_up() {
    Profiler& profiler = device.profiler();
    const double begin = host_seconds(), compiled_s = profiler.compile_s;
    device.write(memory.frame, &frame, sizeof frame);
    for (const auto& [name, kernel] : kernels) device.run(kernel, 1, config.chunked ? 1 : kGroup);
    for (const Slot& slot : slots) device.run(slot.film, 1, config.chunked ? 1 : kGroup);
    device.finish();
    if (config.fused) make_sampler();
    profiler.compile_s = compiled_s + (host_seconds() - begin);  // a driver may compile behind the launch
    profiler.restart();
  }

  /// Launches a stage over the paths of a unit, if this scene needs it: a work-item per chunk, or one for each of `most` queue entries.
  void run_stage(const char* name, std::uint32_t depth, std::uint64_t most, const Slot& slot) {
    const auto found = kernels.find(name);
    if (found == kernels.end()) return;
    found->second.set("depth", depth);
    if (config.chunked)
      device.run(found->second, used_chunks(slot), 1);
    else
      device.run(found->second, divide_up(most, kGroup), kGroup);
  }
  [[nodiscard]] std::uint32_t used_chunks(const Slot& slot) const {
    return config.chunked ? divide_up(slot.frame.path_count, config.chunk) : 1;
  }
  /// The film's work-items own pixels, not paths. Its sums are read back behind it.
  void run_film(Slot& slot) {
    const auto which = std::size_t(&slot - slots.data());
    const std::uint32_t pixel_count = slot.frame.pixel_count;
    if (config.chunked)
      device.run(slot.film, divide_up(pixel_count, EK_FILM_PIXELS), 1, slot.frame.path_count);
    else
      device.run(slot.film, divide_up(pixel_count, kGroup), kGroup, slot.frame.path_count);
    slot.sums.resize(film_shape.sum_words(pixel_count));
    slot.rejected.resize(film_shape.rejected_words(pixel_count));
    const std::size_t path_count = slot.frame.path_count;
    slot.met.resize(std::size_t{film_shape.mattes} * path_count);
    // In the queue, since the next unit clears it; the last of the large ones is waited for.
    device.read_later(memory.diagnostics, &slot.diagnostics, sizeof slot.diagnostics);
    for (std::size_t m = 0; m < film_shape.mattes; ++m)
      device.read_later(memory.film_slots, &slot.met[m * path_count], 4 * path_count,
                        4 * (film_shape.channels + m) * std::size_t{frame.film_stride});
    device.read_beside(memory.rejected[which], slot.rejected.data(), 4 * slot.rejected.size());
    slot.summed = device.read_beside(memory.sums[which], slot.sums.data(), 4 * slot.sums.size());
    device.flush();
  }

  /// The whole algorithm, in one launch.
  void launch_fused(Slot& slot) {
    device.write_later(memory.next_path, &kNoPaths, sizeof kNoPaths);
    device.run(kernels.at("paths"), config.workers, 1, slot.frame.path_count);
    slot.tallied = device.read_later(memory.tallies, slot.tallies.data(), slot.tallies.size() * sizeof(WorkerTally));
    run_film(slot);
  }
  /// Waits for the launch. Counts the rays that it traced.
  void settle_fused(Slot& slot) {
    device.wait(slot.tallied);
    slot.rays = census.add_launch(slot.frame.path_count, slot.tallies,
                                  sampler ? sampler->shares() : stage_shares(slot.tallies));
  }

  /// active  paths at that depth, at most
  void launch_depth(Slot& slot, std::uint32_t depth, std::uint64_t active) {
    census.add_depth(depth, std::uint64_t{divide_up(active, kGroup)} * kGroup);
    run_stage("intersect", depth, active, slot);
    if (after_intersect) after_intersect(depth);
    run_stage("miss", depth, active, slot);
    run_stage("shade", depth, active, slot);
    run_stage("compact", depth, active, slot);
    DepthCounts& at = under_way.emplace_back();
    at.depth = depth;
    at.counts.resize(4 * std::size_t{used_chunks(slot)});
    at.ticket = device.read_later(memory.counts, at.counts.data(), 4 * at.counts.size());
    run_stage("shadow", depth, active * light_samples, slot);
    device.flush();
  }

  /// The first depth of a unit, stage by stage.
  void launch_first(Slot& slot) {
    const std::uint64_t paths = slot.frame.path_count;
    slot.rays.camera = paths;
    census.begin_unit(paths);
    run_stage("generate", 1, paths, slot);
    launch_depth(slot, 1, paths);
  }

  /// The rest of them. The host looks at the counts of a depth while the next is already under way; the price is one round of empty
  /// launches at the end of a unit.
  void launch_rest(Slot& slot) {
    const std::size_t ahead = after_intersect ? 0 : 1;
    std::uint64_t active = slot.frame.path_count;  // at least the paths that go on
    for (std::uint32_t depth = 2; active > 0; ++depth) {
      while (active > 0 && under_way.size() > ahead) {
        active = settle(slot, under_way.front());
        under_way.pop_front();
      }
      if (active > 0) launch_depth(slot, depth, active);
    }
    run_film(slot);
    // Their counts are zero. They lie before the film in the queue, and with them memory that is written to.
    for (const DepthCounts& at : under_way) device.wait(at.ticket);
    under_way.clear();
  }

  /// Waits for the counts of a depth; returns how many paths go on.
  std::uint64_t settle(Slot& slot, const DepthCounts& at) {
    device.wait(at.ticket);
    const RayCounts on = census.end_depth(at.depth, std::span(at.counts).first(4 * std::size_t{used_chunks(slot)}),
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
    if (unit.path_count() > config.capacity() || 4 * slot.pixels.size() > memory.pixels.size_bytes())
      throw InternalError(
          fmt::format("a unit of {} paths exceeds the pool of {}", unit.path_count(), config.capacity()));
    slot.frame = frame;
    slot.frame.pixel_count = std::uint32_t(slot.pixels.size());
    slot.frame.pixel_stride = slot.frame.pixel_count + EK_PAD;
    slot.frame.sample_count = std::uint32_t(unit.sample_end - unit.sample_begin);
    slot.frame.path_count = slot.frame.pixel_count * slot.frame.sample_count;
    slot.frame.sample_begin = std::uint32_t(unit.sample_begin);
    slot.frame.sample_high = std::uint32_t(unit.sample_begin >> 32);
    device.begin_unit(slot.frame.path_count);
    if (sampler) sampler->before(slot.frame, slot.pixels);
    device.write_later(memory.frame, &slot.frame, sizeof slot.frame);
    device.write_later(memory.pixels, slot.pixels.data(), 4 * slot.pixels.size());
    device.write_later(memory.diagnostics, &slot.nothing, sizeof slot.nothing);
    ++begun;
    if (config.fused) {
      launch_fused(slot);
      driven = begun;
    } else {
      launch_first(slot);
    }
  }

  void drive() {
    if (driven == begun) return;
    launch_rest(slots[driven % slots.size()]);
    ++driven;
  }

  UnitResult finish() {
    if (finished == begun) throw InternalError("no unit was begun");
    if (finished == driven) drive();
    Slot& slot = slots[finished % slots.size()];
    ++finished;
    if (config.fused) settle_fused(slot);
    device.wait(slot.summed);
    UnitResult result;
    result.rays = slot.rays;
    const Diagnostics& diagnostics = slot.diagnostics;
    result.nonfinite = diagnostics.nonfinite;
    result.saturated = diagnostics.saturated;
    result.given_up = diagnostics.given_up;
    result.given_up_surfaces = diagnostics.given_up_surfaces;
    for (std::uint32_t i = 0; i < std::min<std::uint32_t>(diagnostics.reported, EK_REPORT_COUNT); ++i) {
      const std::uint32_t xy = slot.pixels[diagnostics.report[2 * i]];
      result.rejected.push_back({xy & 0xffffU, xy >> 16, slot.unit.sample_begin + diagnostics.report[2 * i + 1]});
    }
    result.sums.pixels = slot.pixels;
    result.sums.pixel_stride = slot.frame.pixel_stride;
    result.sums.sample_begin = slot.unit.sample_begin;
    result.sums.sample_end = slot.unit.sample_end;
    result.sums.limbs = slot.sums;
    result.sums.rejected = slot.rejected;
    result.sums.met = slot.met;
    result.sums.matte_ids = mattes.ids;
    return result;
  }

  [[nodiscard]] std::uint32_t path_word(const char* field, std::uint32_t part = 0) {
    std::uint32_t word = 0;
    device.read(memory.state, &word, sizeof word, 4 * std::size_t{state.field.at(field) + part} * (config.chunk + EK_PAD));
    return word;
  }
  [[nodiscard]] float path_float(const char* field, std::uint32_t part = 0) {
    return std::bit_cast<float>(path_word(field, part));
  }
};

Wavefront::Wavefront(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
                     const Execution& execution)
    : impl_(std::make_unique<Impl>(device, scene, features, settings, execution)) {}
Wavefront::~Wavefront() = default;

void Wavefront::compile_ahead(Device& device, const PackedScene& scene, const Features& features,
                              const Execution& execution) {
  const WavefrontProgram source(device.info(), configure(device.info(), execution), scene, features, execution);
  (void)device.build(source.text, source.options);
}

const WavefrontConfig& Wavefront::config() const { return impl_->config; }
ArithmeticClass Wavefront::arithmetic() const { return impl_->arithmetic; }
double Wavefront::upload_s() const { return impl_->upload_s; }
std::uint64_t Wavefront::device_bytes() const { return impl_->scene_bytes + impl_->memory.bytes; }
const Bounces& Wavefront::bounces() const { return impl_->census.bounces(); }

void Wavefront::restart(const Settings& settings, const Execution& execution) { impl_->restart(settings, execution); }

void Wavefront::begin(const WorkUnit& unit) { impl_->begin(unit); }
void Wavefront::drive() { impl_->drive(); }
UnitResult Wavefront::finish() { return impl_->finish(); }

glm::vec3 Wavefront::replay(std::uint32_t x, std::uint32_t y, std::uint64_t sample,
                            const std::function<void(const PathVertex&)>& report) {
  Impl& w = *impl_;
  if (w.config.fused) throw InternalError("a path can be watched only where each stage has a launch of its own");
  WorkUnit unit;
  unit.block = {x, y, x + 1, y + 1};
  unit.sample_begin = sample;
  unit.sample_end = sample + 1;
  w.after_intersect = [&](std::uint32_t depth) {
    PathVertex vertex;
    vertex.depth = depth;
    vertex.origin = {w.path_float("origin", 0), w.path_float("origin", 1), w.path_float("origin", 2)};
    vertex.dir = {w.path_float("dir", 0), w.path_float("dir", 1), w.path_float("dir", 2)};
    vertex.beta = {w.path_float("beta", 0), w.path_float("beta", 1), w.path_float("beta", 2)};
    vertex.t = w.path_float("hit_t");
    vertex.triangle = w.path_word("hit_triangle");
    report(vertex);
  };
  w.begin(unit);
  (void)w.finish();
  w.after_intersect = nullptr;
  glm::vec3 radiance;
  for (int c = 0; c < 3; ++c)
    w.device.read(w.memory.film_slots, &radiance[c], sizeof(float), 4 * std::size_t(c) * w.frame.film_stride);
  return radiance;
}

}  // namespace eikon
