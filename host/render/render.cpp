// SPDX-License-Identifier: Apache-2.0
#include "render/render.h"

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <set>
#include <thread>
#include <utility>

#include "core/error.h"
#include "render/crew.h"
#include "render/device_worker.h"
#include "render/error_counter.h"
#include "wavefront/memory.h"
#include "render/no_device_left.h"
#include "pack/pack.h"
#include "pack/geometry/placed_meshes.h"

namespace eikon {
namespace {

/// What is left of the range of samples, cut where the film is to be looked at.
class Stretches {
 public:
  Stretches(const Looks& looks, const Settings& settings) : looks_(looks), settings_(settings) {
    std::uint64_t begin = settings.sample_begin;
    for (const std::uint64_t end : looks.at) {
      if (end <= begin || end > settings.sample_end) throw InternalError("looks out of order, or beyond the samples");
      begin = end;
    }
    begin_ = settings.sample_begin;
  }
  [[nodiscard]] bool at_end() const { return begin_ >= settings_.sample_end; }
  void open_next(Crew& crew) {
    end_ = index_ < looks_.at.size() ? looks_.at[index_] : settings_.sample_end;
    crew.open(crew.film().missing(settings_.crop, begin_, end_));
  }
  /// All of it is done.
  void close(Crew& crew) {
    if (index_ < looks_.at.size())
      crew.film().look([&](const Film& film) { looks_.look(end_, crew.totals().render_s, film); });
    ++index_;
    begin_ = end_;
  }

 private:
  const Looks& looks_;
  const Settings& settings_;
  std::size_t index_ = 0;
  std::uint64_t begin_ = 0, end_ = 0;
};

/// Hands copies of the film to the hook, when they are due: so early that the one before is never older than an interval when the
/// hook is done, if it takes as long as it did then; but it has no more than half of the time.
class Checkpoints {
 public:
  Checkpoints(const RenderHooks& hooks, Trace* trace)
      : hooks_(hooks), trace_(trace), next_s_(host_seconds() + hooks.checkpoint_every_s) {}
  void call_if_due(Crew& crew, bool at_end) {
    const std::uint64_t samples = crew.totals().samples;
    if (!hooks_.checkpoint || samples == samples_ || crew.film().spoiled()) return;
    const bool asked = hooks_.checkpoint_now != nullptr && hooks_.checkpoint_now->exchange(false);
    if (!asked && !at_end && host_seconds() < next_s_) return;
    samples_ = samples;
    const TraceScope checkpointing(trace_, Trace::kMain, "checkpoint");
    const double begin_s = host_seconds();
    hooks_.checkpoint(crew.film().copy());
    const double end_s = host_seconds(), took_s = end_s - begin_s;
    next_s_ = std::max(begin_s + hooks_.checkpoint_every_s - took_s, end_s + took_s);
  }

 private:
  const RenderHooks& hooks_;
  Trace* trace_;
  double next_s_;
  std::uint64_t samples_ = 0;
};

/// Tells how far it is, about four times a second.
class ProgressTicks {
 public:
  /// before, total: samples that are done already, and all that was asked for
  ProgressTicks(const ProgressCallback& tell, std::uint64_t before, std::uint64_t total)
      : tell_(tell), before_(before), total_(total) {}
  void call_if_due(Crew& crew) {
    if (!tell_ || host_seconds() < next_s_) return;
    const Crew::Totals totals = crew.totals();
    if (totals.samples == 0) return;
    Progress now;
    now.samples = before_ + totals.samples;
    now.samples_total = total_;
    now.seconds = host_seconds() - totals.first_sample_s;
    now.samples_per_second = now.seconds > 0 ? double(totals.samples) / now.seconds : 0;
    crew.film().look([&](const Film& film) { tell_(now, film); });
    next_s_ = host_seconds() + 0.25;
  }

 private:
  const ProgressCallback& tell_;
  std::uint64_t before_, total_;
  double next_s_ = 0;
};

/// The devices' threads. Whatever happens, they end before what they do not own goes, or are left alone.
class Threads {
 public:
  explicit Threads(std::shared_ptr<Crew> crew) : crew_(std::move(crew)) {}
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() { end(); }
  void start(std::size_t device, const OpenRunner& open) {
    threads_.emplace_back(device, std::thread([crew = crew_, open, device] { run_device(crew, device, open); }));
  }
  void end() {
    if (threads_.empty()) return;
    crew_->end();
    crew_->wait_for_threads();
    for (auto& [device, thread] : threads_) {
      if (crew_->is_lost(device))
        thread.detach();
      else
        thread.join();
    }
    threads_.clear();
  }

 private:
  std::shared_ptr<Crew> crew_;
  std::vector<std::pair<std::size_t, std::thread>> threads_;  // with their devices
};

/// Until all is done, somebody says stop, or nobody is there to do it.
Crew::State conduct(Crew& crew, Stretches& stretches, const RenderHooks& hooks, const std::atomic<bool>& stop,
                    Checkpoints& checkpoints, ErrorCounter& errors, ProgressTicks progress) {
  // At signals and clocks.
  const double look_s = hooks.checkpoint ? std::clamp(hooks.checkpoint_every_s, 0.01, 0.05) : 0.05;
  bool told = !hooks.under_way;
  stretches.open_next(crew);
  while (!stop.load()) {
    crew.wait(look_s);
    crew.watch();
    if (!told && !crew.is_opening()) hooks.under_way(), told = true;
    const Crew::State state = crew.state();
    if (state == Crew::State::done) {
      if (stop.load()) break;
      stretches.close(crew);
      if (stretches.at_end()) return state;
      if (stop.load()) break;
      stretches.open_next(crew);
    } else if (state != Crew::State::working) {
      return state;
    }
    checkpoints.call_if_due(crew, false);
    progress.call_if_due(crew);
    errors.look_if_due(crew.film());
  }
  return Crew::State::working;
}

}  // namespace

std::string RenderReport::arithmetic() const {
  std::set<std::string> classes;
  for (const DeviceReport& device : devices)
    if (device.units > 0) classes.insert(device.arithmetic.name());
  std::string text;
  for (const std::string& name : classes) text += (text.empty() ? "" : ", ") + name;
  return text;
}

FilmLayout film_layout(const Features& features, const Settings& settings) {
  FilmLayout layout;
  layout.width = settings.width;
  layout.height = settings.height;
  layout.crop = settings.crop;
  layout.replicates = 1U << settings.replicate_bits;
  layout.channels = features.film_channels();
  layout.mattes = features.mattes().layers;
  return layout;
}

namespace {

/// The layout that each device is to use, and its tree; or why it cannot take part. throws DeviceError when none can
std::vector<DeviceReport> prepare_devices(WavefrontCrew& crew, const Execution& execution) {
  std::vector<DeviceReport> reports;
  std::string errors;
  for (const DeviceInfo& info : crew.devices) {
    DeviceReport& report = reports.emplace_back();
    Execution& own = crew.executions.emplace_back(execution);
    report.info = info;
    try {
      report.layout = choose_layout(info, *crew.packed, crew.features, crew.settings, execution);
      own.layout = report.layout.layout;
      require_memory(memory_need(*crew.packed, configure(info, own), crew.features), info, execution);
    } catch (const DeviceError& error) {
      if (crew.devices.size() == 1) throw;
      errors += fmt::format("{}device {}: {}", errors.empty() ? "" : "; ", info.selector, error.what());
      report.error = error.what();
    }
  }
  if (std::none_of(reports.begin(), reports.end(), [](const DeviceReport& r) { return r.error.empty(); }))
    throw DeviceError(errors);
  return reports;
}

std::string no_device_is_left(Crew& crew, std::uint64_t samples, std::uint64_t total) {
  const std::string why = crew.last_words();
  if (samples == 0) return why;
  return fmt::format("no device is left, with {:.1f} % of {} samples done: {}", 100 * double(samples) / double(total),
                     total, why);
}

/// Whether all that is asked for is done before the render begins: it takes no device then.
bool is_nothing_left(const RenderHooks& hooks, const Settings& settings) {
  return hooks.begin_with && hooks.looks.at.empty() &&
         hooks.begin_with->done.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
}

RenderOutput output_of(FilmState done, const Features& features) {
  RenderReport report;
  report.samples_before = done.done.sample_count();
  report.features = features.summary();
  return {std::move(done.film), std::move(report), std::move(done.done), std::move(done.arithmetic)};
}

/// `pack` gives the PackedScene; it is called once it is certain that there are devices.
template <class Pack>
RenderOutput pack_and_render(const Pack& pack, const Features& features, const Settings& settings,
                             const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  if (is_nothing_left(hooks, settings)) return output_of(std::move(*hooks.begin_with), features);
  RenderReport report;
  DevicePool pool = hooks.devices != nullptr ? *hooks.devices : DevicePool();
  const std::vector<DeviceInfo> selected = pool.select(execution.devices, execution.threads, &report.notes);
  const double pack_begin = host_seconds();
  TraceScope packing(execution.trace.get(), execution.track, "pack");
  const std::shared_ptr<PackedScene> packed_scene = pack();
  packing.end();
  PackedScene& packed = *packed_scene;
  const double pack_s = host_seconds() - pack_begin, built_before_s = packed.build_s;
  const auto made = std::make_shared<WavefrontCrew>(WavefrontCrew{.devices = selected,
                                                                  .executions = {},
                                                                  .packed = packed_scene,
                                                                  .features = features,
                                                                  .settings = settings,
                                                                  .pool = std::move(pool),
                                                                  .keep = hooks.keep,
                                                                  .stay = hooks.devices_stay_ready});
  TraceScope building(execution.trace.get(), execution.track, "choose layout, build tree");
  const std::vector<DeviceReport> reports = prepare_devices(*made, execution);
  building.end();

  const auto first =
      std::find_if(reports.begin(), reports.end(), [](const DeviceReport& r) { return r.error.empty(); });
  const std::string& layout = first->layout.layout;
  require_host_memory(film_layout(features, settings), bool(hooks.checkpoint), packed.bytes(layout), host_limits());
  FilmState begin = hooks.begin_with ? std::move(*hooks.begin_with)
                                     : FilmState{Film(film_layout(features, settings)), SampleLedger()};
  if (begin.film.layout() != film_layout(features, settings))
    throw InternalError("a render goes on with a film of other layout");
  report.samples_before = begin.done.sample_count();
  const std::vector<WorkUnit> missing = begin.done.missing(settings.crop, settings.sample_begin, settings.sample_end);
  std::uint64_t total = 0;
  for (const WorkUnit& box : missing) total += box.path_count();

  const auto crew = std::make_shared<Crew>(reports, std::move(begin), execution.block, execution.watchdog_s);
  Stretches stretches(hooks.looks, settings);
  Checkpoints checkpoints(hooks, execution.trace.get());
  ErrorCounter errors(execution.trace.get(), settings.crop.pixel_count());
  TraceScope rendering(execution.trace.get(), execution.track, "render");
  Threads threads(crew);
  for (std::size_t i = 0; i < reports.size(); ++i)
    if (total > 0 && reports[i].error.empty()) threads.start(i, open_wavefronts(made));
  const std::uint64_t asked = settings.crop.pixel_count() * (settings.sample_end - settings.sample_begin);
  const Crew::State state =
      conduct(*crew, stretches, hooks, stop, checkpoints, errors, {hooks.progress, asked - total, asked});
  threads.end();
  for (const DeviceEvent& event : crew->events())
    if (event.kind == DeviceEvent::Kind::hung) made->pool.give_up(selected[event.device], event.text);
  checkpoints.call_if_due(*crew, true);
  rendering.end();
  if (const std::exception_ptr error = crew->error()) std::rethrow_exception(error);
  const Crew::Totals totals = crew->totals();
  const bool unmanned = state == Crew::State::unmanned;
  if (unmanned && totals.samples == 0) throw DeviceError(no_device_is_left(*crew, 0, total));

  report.devices = crew->device_reports();
  report.events = crew->events();
  report.rays = totals.rays;
  report.samples = totals.samples;
  report.given_up = totals.given_up;
  report.given_up_surfaces = totals.given_up_surfaces;
  report.nonfinite = totals.nonfinite;
  report.saturated = totals.saturated;
  report.rejected = totals.rejected;
  report.first_sample_s = totals.first_sample_s;
  report.render_s = totals.render_s;
  for (const DeviceReport& device : report.devices) {
    report.compile_s = std::max(report.compile_s, device.compile_s);
    report.upload_s = std::max(report.upload_s, device.upload_s);
  }
  report.features = features.summary();
  report.triangles = packed.seen_triangle_count();
  report.geometry_bytes = packed.bytes(layout);
  const auto tree = packed.accels.find(layout);
  report.reinserted = tree != packed.accels.end() && tree->second.reinserted;
  report.pack_s = pack_s;
  report.build_s = packed.build_s - built_before_s;
  FilmState done = crew->film().take();
  report.interrupted = !done.done.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
  RenderOutput output{std::move(done.film), std::move(report), std::move(done.done), std::move(done.arithmetic)};
  if (unmanned) throw NoDeviceLeft(no_device_is_left(*crew, totals.samples, total), std::move(output));
  return output;
}

}  // namespace

RenderOutput render(const Scene& scene, const Settings& settings, const Execution& execution,
                    const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features = features_of(scene, settings, execution);
  const auto pack = [&] { return std::make_shared<PackedScene>(pack_scene(scene, features, settings)); };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_and_release(Scene& scene, const Settings& settings, const Execution& execution,
                                const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features = features_of(scene, settings, execution);
  const auto pack = [&] { return std::make_shared<PackedScene>(pack_and_release(scene, features, settings)); };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_packed(std::shared_ptr<PackedScene> packed, const Features& features, const Settings& settings,
                           const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  const auto pack = [&] { return packed; };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

glm::vec3 replay_path(const Scene& scene, const Settings& settings, const Execution& usual, std::uint32_t x,
                      std::uint32_t y, std::uint64_t sample, const std::function<void(const PathVertex&)>& report) {
  Execution execution = usual;
  execution.fused = false;
  const DeviceInfo info = select_devices(execution.devices, execution.threads).front();
  const Features features = features_of(scene, settings, execution);
  PackedScene packed = pack_scene(scene, features, settings);
  const Execution own = without_probe(execution);  // one path is too few to measure for
  const WavefrontConfig config = configure(info, own);
  add_accel(packed, own.accel, config.layout, own.threads);
  require_memory(memory_need(packed, config, features), info, own);
  Device device(info);
  Wavefront wavefront(device, packed, features, settings, own);
  return wavefront.replay(x, y, sample, report);
}

}  // namespace eikon
