// SPDX-License-Identifier: Apache-2.0
#include "render/render.h"

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <thread>

#include "film/layers.h"
#include "pack/geometry/instanced_meshes.h"
#include "pack/pack.h"
#include "render/device_sessions.h"
#include "render/device_worker.h"
#include "render/error_curve.h"
#include "render/film_record.h"
#include "render/pilot/pilot.h"
#include "render/pilot/pilot_thread.h"
#include "render/rounds.h"
#include "wavefront/memory_need.h"
#include "wavefront/photons/photon_map.h"

namespace eikon {
namespace {

/// Hands copies of the film to RenderHooks::checkpoint when they are due. A kill of the process
/// loses what came after the last checkpoint on the disk, so the next is begun as much earlier as
/// the last one took. Checkpoints that take long still leave half of the time to the render.
class Checkpoints {
 public:
  Checkpoints(const RenderHooks& hooks, Trace* trace)
      : hooks_(hooks), trace_(trace), next_s_(host_seconds() + hooks.checkpoint_every_s) {}
  void call_if_due(DeviceSessions& sessions, bool at_end) {
    const std::uint64_t samples = sessions.totals().samples;
    if (!hooks_.checkpoint || samples == samples_ || sessions.film().spoiled()) return;
    const bool asked = hooks_.checkpoint_now != nullptr && hooks_.checkpoint_now->exchange(false);
    if (!asked && !at_end && host_seconds() < next_s_) return;
    samples_ = samples;
    const TraceScope checkpointing(trace_, Trace::kMain, "checkpoint");
    const double begin_s = host_seconds();
    hooks_.checkpoint(sessions.film().copy());
    const double end_s = host_seconds(), took_s = end_s - begin_s;
    next_s_ = std::max(begin_s + hooks_.checkpoint_every_s - took_s, end_s + took_s);
  }

 private:
  const RenderHooks& hooks_;
  Trace* trace_;
  double next_s_;
  std::uint64_t samples_ = 0;
};

/// Reports progress about four times a second.
class ProgressTicks {
 public:
  /// before, total: samples that were done when the render began, and all that were asked for
  ProgressTicks(const ProgressCallback& callback, std::uint64_t before, std::uint64_t total)
      : callback_(callback), before_(before), total_(total) {}
  void call_if_due(DeviceSessions& sessions) {
    if (!callback_ || host_seconds() < next_s_) return;
    const RenderTotals totals = sessions.totals();
    if (totals.samples == 0) return;
    Progress now;
    now.samples = before_ + totals.samples;
    now.samples_total = total_;
    now.seconds = host_seconds() - totals.first_sample_s;
    now.samples_per_second = now.seconds > 0 ? double(totals.samples) / now.seconds : 0;
    now.share = double(now.samples) / double(now.samples_total);
    now.left_s = now.samples_per_second > 0 ? double(total_ - now.samples) / now.samples_per_second : 0;
    sessions.film().read([&](const Film& film) { callback_(now, film); });
    next_s_ = host_seconds() + 0.25;
  }

 private:
  const ProgressCallback& callback_;
  std::uint64_t before_, total_;
  double next_s_ = 0;
};

/// The threads of the devices. Its destructor waits for them, also after an exception, because they
/// use what the caller owns; a thread that hangs is detached and uses only what it shares.
class Threads {
 public:
  explicit Threads(std::shared_ptr<DeviceSessions> sessions) : sessions_(std::move(sessions)) {}
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() { end(); }
  void start(std::size_t device, const OpenRunner& open) {
    threads_.emplace_back(device,
                          std::thread([sessions = sessions_, open, device] { run_device(sessions, device, open); }));
  }
  void end() {
    if (threads_.empty()) return;
    sessions_->end();
    sessions_->wait_for_threads();
    for (auto& [device, thread] : threads_) {
      if (sessions_->is_lost(device))
        thread.detach();
      else
        thread.join();
    }
    threads_.clear();
  }

 private:
  std::shared_ptr<DeviceSessions> sessions_;
  std::vector<std::pair<std::size_t, std::thread>> threads_;  // with their devices
};

/// Runs on the calling thread while the devices work: opens one round of samples after the other,
/// calls the hooks, and watches for devices that hang.
class RenderLoop {
 public:
  /// left: samples that are still to be done
  RenderLoop(DeviceSessions& sessions, const RenderHooks& hooks, const Settings& settings, Trace* trace, Rounds& rounds,
             std::uint64_t left)
      : sessions_(sessions),
        hooks_(hooks),
        rounds_(rounds),
        checkpoints_(hooks, trace),
        error_curve_(trace, settings.crop.pixel_count(), hooks.error_share),
        progress_(hooks.progress, total_of(settings) - left, total_of(settings)) {}

  /// Returns when no round is left, when `stop` is set or the time is over (the state is then
  /// `working`), or when no device is left.
  DeviceSessions::State run_to_completion(const std::atomic<bool>& stop) {
    // Signals and clocks wake nobody, so the thread looks after them at this interval.
    const double due_s = hooks_.checkpoint ? std::max(hooks_.checkpoint_every_s, 0.01) : hooks_.wake_s;
    const double wake_s = std::min(due_s, hooks_.wake_s);
    bool is_under_way = !hooks_.under_way;
    rounds_.open(sessions_);
    while (!stop.load() && !rounds_.is_out_of_time()) {
      sessions_.wait(wake_s);
      sessions_.watch();
      if (!is_under_way && !sessions_.is_opening()) {
        hooks_.under_way();
        is_under_way = true;
      }
      const DeviceSessions::State state = sessions_.state();
      if (state == DeviceSessions::State::done) {
        if (stop.load()) break;
        rounds_.close(sessions_);
        if (rounds_.over()) return state;
        if (stop.load()) break;
        rounds_.open(sessions_);
      } else if (state != DeviceSessions::State::working) {
        return state;
      }
      checkpoints_.call_if_due(sessions_, false);
      progress_.call_if_due(sessions_);
      error_curve_.add_point_if_due(sessions_.film());
    }
    return DeviceSessions::State::working;
  }
  void last_checkpoint() { checkpoints_.call_if_due(sessions_, true); }

 private:
  static std::uint64_t total_of(const Settings& settings) {
    return settings.crop.pixel_count() * (settings.sample_end - settings.sample_begin);
  }

  DeviceSessions& sessions_;
  const RenderHooks& hooks_;
  Rounds& rounds_;
  Checkpoints checkpoints_;
  ErrorCurve error_curve_;
  ProgressTicks progress_;
};

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
  if (features.has(Feature::light_paths)) {
    const std::vector<std::string> splats = splat_channels_of(layout.channels);
    layout.channels.insert(layout.channels.end(), splats.begin(), splats.end());
  }
  layout.mattes = features.mattes().layers;
  return layout;
}

namespace {

/// Chooses each device's layout and builds its tree; a report with an error says why a device
/// cannot take part.
/// throws DeviceError when none can
std::vector<DeviceReport> prepare_devices(WavefrontDevices& devices, const Execution& execution) {
  const TraceScope building(execution.trace.get(), execution.track, "choose layout, build tree");
  std::vector<DeviceReport> reports;
  std::string errors;
  for (const DeviceInfo& info : devices.devices) {
    DeviceReport& report = reports.emplace_back();
    Execution& own = devices.executions.emplace_back(execution);
    report.info = info;
    try {
      report.layout = choose_layout(info, *devices.packed, devices.features, devices.settings, execution);
      own.layout = report.layout.layout;
      own = fit_units(*devices.packed, info, devices.features, devices.settings, own);
      require_memory(memory_need(*devices.packed, configure(info, own), devices.features, devices.settings), info,
                     execution);
    } catch (const DeviceError& error) {
      if (devices.devices.size() == 1) throw;
      errors += fmt::format("{}device {}: {}", errors.empty() ? "" : "; ", info.selector, error.what());
      report.error = error.what();
    }
  }
  if (std::none_of(reports.begin(), reports.end(), [](const DeviceReport& r) { return r.error.empty(); }))
    throw DeviceError(errors);
  return reports;
}

std::string no_device_is_left(DeviceSessions& sessions, std::uint64_t samples, std::uint64_t total) {
  const std::string why = sessions.failure_summary();
  if (samples == 0) return why;
  return fmt::format("no device is left, with {:.1f} % of {} samples done: {}", 100 * double(samples) / double(total),
                     total, why);
}

/// All that is asked for was done before the render began, so it takes no device.
bool is_nothing_left(const RenderHooks& hooks, const Settings& settings) {
  return hooks.begin_with && !hooks.next_round &&
         hooks.begin_with->sample_set.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
}

RenderOutput output_of(FilmState done, const Features& features) {
  RenderReport report;
  report.samples_before = done.sample_set.sample_count();
  report.set_features(features);
  return {std::move(done), std::move(report)};
}

/// The film that the render begins with. throws DeviceError when the host lacks the memory for it
FilmState first_film(RenderHooks& hooks, const WavefrontDevices& devices, const std::string& layout) {
  const FilmLayout& wanted = devices.film;
  require_host_memory(wanted, bool(hooks.checkpoint), devices.packed->bytes(layout), host_limits());
  FilmState begin = hooks.begin_with ? std::move(*hooks.begin_with) : FilmState{Film(wanted), SampleSet()};
  if (begin.film.layout() != wanted) throw InternalError("a render goes on with a film of other layout");
  return begin;
}

/// layout: of the first device that took part
void fill_report(RenderReport& report, DeviceSessions& sessions, const WavefrontDevices& devices,
                 const std::string& layout) {
  static_cast<RenderTotals&>(report) = sessions.totals();
  report.devices = sessions.device_reports();
  report.events = sessions.events();
  for (const DeviceReport& device : report.devices) {
    report.compile_s = std::max(report.compile_s, device.compile_s);
    report.upload_s = std::max(report.upload_s, device.upload_s);
  }
  report.set_features(devices.features);
  report.triangles = devices.packed->instanced_triangle_count();
  report.geometry_bytes = devices.packed->bytes(layout);
  const auto tree = devices.packed->accels.find(layout);
  report.reinserted = tree != devices.packed->accels.end() && tree->second.reinserted;
}

/// Why a render ended that leaves samples undone.
/// cut_short       the pilot took all of the time
/// no_device_left  nobody can render what is left
RenderEnd reason_of_end(const Rounds& rounds, bool cut_short, bool stopped, bool no_device_left) {
  if (rounds.over()) return RenderEnd::target_error;
  const bool out_of_time = rounds.is_out_of_time() || cut_short;
  return out_of_time && !stopped && !no_device_left ? RenderEnd::time_limit : RenderEnd::interrupted;
}

/// Renders with the devices that have no error in `prepared`, from the film that the hooks give
/// until the hooks, `stop` or the last sample end it.
/// report  what is known before the devices begin
/// throws NoDeviceLeft if no device is left and some samples are done, DeviceError if none is done;
RenderOutput render_on(const std::shared_ptr<WavefrontDevices>& devices, const Execution& execution,
                       const std::vector<DeviceReport>& prepared, const std::atomic<bool>& stop, RenderHooks& hooks,
                       RenderReport report) {
  const Settings& settings = devices->settings;
  const auto first =
      std::find_if(prepared.begin(), prepared.end(), [](const DeviceReport& r) { return r.error.empty(); });
  const std::string& layout = first->layout.layout;
  FilmState begin = first_film(hooks, *devices, layout);
  if (!report.pilot.cut_short) agree_on_pilot(begin, settings, report.pilot, report.notes);
  report.samples_before = begin.sample_set.sample_count();
  std::uint64_t left = 0;
  for (const WorkUnit& box : begin.sample_set.missing(settings.crop, settings.sample_begin, settings.sample_end))
    left += box.path_count();

  Rounds rounds(hooks, settings, begin, report.pilot.seconds);
  const auto sessions =
      std::make_shared<DeviceSessions>(prepared, std::move(begin), block_side(*devices), execution.watchdog_s);
  if (const PhotonPlan photons = photon_plan(settings); photons.paths > 0) sessions->set_period(photons.samples);
  RenderLoop loop(*sessions, hooks, settings, execution.trace.get(), rounds, left);
  TraceScope rendering(execution.trace.get(), execution.track, "render");
  Threads threads(sessions);
  const bool has_time = !report.pilot.cut_short;
  for (std::size_t i = 0; i < prepared.size(); ++i)
    if (has_time && left > 0 && !rounds.over() && prepared[i].error.empty()) threads.start(i, open_wavefronts(devices));
  const DeviceSessions::State state = has_time ? loop.run_to_completion(stop) : DeviceSessions::State::working;
  threads.end();
  for (const DeviceEvent& event : sessions->events())
    if (event.kind == DeviceEvent::Kind::hung) devices->pool.abandon(devices->devices[event.device], event.text);
  loop.last_checkpoint();
  rendering.end();
  if (const std::exception_ptr error = sessions->error()) std::rethrow_exception(error);
  const bool no_device_left = state == DeviceSessions::State::no_device_left;
  fill_report(report, *sessions, *devices, layout);
  const std::uint64_t samples = report.samples;
  if (no_device_left && samples == 0) throw DeviceError(no_device_is_left(*sessions, 0, left));

  FilmState done = sessions->film().take();
  if (!done.sample_set.missing(settings.crop, settings.sample_begin, settings.sample_end).empty())
    report.end = reason_of_end(rounds, !has_time, stop.load(), no_device_left);
  RenderOutput output{std::move(done), std::move(report)};
  if (no_device_left) throw NoDeviceLeft(no_device_is_left(*sessions, samples, left), std::move(output));
  return output;
}

/// Finds devices, packs the scene, builds its trees, prepares the pilot, and renders.
/// pack  returns the PackedScene; it is called once it is certain that there are devices, as it may
///       release the meshes
template <class Pack>
RenderOutput pack_and_render(const Pack& pack, const Features& features, const Settings& settings,
                             const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  if (is_nothing_left(hooks, settings)) return output_of(std::move(*hooks.begin_with), features);
  RenderReport report;
  DevicePool pool = hooks.devices != nullptr ? *hooks.devices : DevicePool();
  TraceScope finding(execution.trace.get(), execution.track, "find devices");
  const std::vector<DeviceInfo> selected = devices_of(pool, execution, &report.notes);
  finding.end();
  const double pack_begin_s = host_seconds();
  TraceScope packing(execution.trace.get(), execution.track, "pack");
  const std::shared_ptr<PackedScene> packed = pack();
  packing.end();
  report.pack_s = host_seconds() - pack_begin_s;
  const double built_before_s = packed->build_s;
  const auto devices = std::make_shared<WavefrontDevices>(WavefrontDevices{.devices = selected,
                                                                           .executions = {},
                                                                           .packed = packed,
                                                                           .features = features,
                                                                           .settings = settings,
                                                                           .film = film_layout(features, settings),
                                                                           .pool = std::move(pool),
                                                                           .stay = hooks.devices_stay_ready,
                                                                           .asked_unit_paths = execution.unit_paths});
  std::vector<DeviceReport> prepared = prepare_devices(*devices, execution);
  report.build_s = packed->build_s - built_before_s;
  if (hooks.opening) hooks.opening();
  TraceScope piloting(execution.trace.get(), execution.track, "pilot");
  prepare_pilot(*devices, prepared, stop, hooks, report);
  piloting.end();
  return render_on(devices, execution, prepared, stop, hooks, std::move(report));
}

}  // namespace

RenderOutput render(const Scene& scene, const Settings& settings, const Execution& execution,
                    const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features = features_of(scene, settings, execution);
  const auto pack = [&, owner = hooks.scene_owner] { return share(pack_scene(scene, features, settings), owner); };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_and_release(Scene& scene, const Settings& settings, const Execution& execution,
                                const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features = features_of(scene, settings, execution);
  const auto pack = [&, owner = hooks.scene_owner] {
    return share(pack_and_release(scene, features, settings), owner);
  };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_packed(std::shared_ptr<PackedScene> packed, const Features& features, const Settings& settings,
                           const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  const auto pack = [&] { return packed; };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

}  // namespace eikon
