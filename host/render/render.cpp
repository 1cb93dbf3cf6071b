// SPDX-License-Identifier: Apache-2.0
#include "render/render.h"

#include <algorithm>
#include <barrier>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "core/error.h"
#include "render/memory.h"
#include "render/pack.h"

namespace eikon {
namespace {

/// Units of the boxes of samples that are to be done, one box after the other.
class Plan {
 public:
  void add(const UnitPlan& units) {
    boxes_.push_back(units);
    size_ += units.size();
  }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] WorkUnit operator[](std::uint64_t index) const {
    std::size_t box = 0;
    while (index >= boxes_[box].size()) index -= boxes_[box++].size();
    return boxes_[box][index];
  }

 private:
  std::vector<UnitPlan> boxes_;
  std::uint64_t size_ = 0;
};

/// What the device threads share. Everything below `mutex` is guarded by it.
struct Shared {
  const std::vector<Plan>& plans;  // one after the other
  const std::atomic<bool>& stop;
  std::vector<std::atomic<std::uint64_t>> next_unit;  // of each plan
  std::atomic<bool> failed{false};

  std::mutex mutex;
  std::condition_variable changed;
  FilmState state;
  RenderReport report;
  std::exception_ptr error;
  std::size_t running = 0;

  Shared(const std::vector<Plan>& units, const std::atomic<bool>& stopped, FilmState begin)
      : plans(units), stop(stopped), next_unit(units.size()), state(std::move(begin)) {}

  [[nodiscard]] bool should_stop() const { return stop.load() || failed.load(); }
};

struct Job {
  const PackedScene& scene;
  const Features& features;
  const Settings& settings;
  const Execution& execution;
  DevicePool& devices;
};

void merge(Shared& shared, const UnitResult& result, const WorkUnit& unit, const std::string& arithmetic) {
  const std::lock_guard lock(shared.mutex);
  shared.state.film.add(result.sums);
  shared.state.done.add(unit);
  shared.state.arithmetic.insert(arithmetic);
  RenderReport& report = shared.report;
  if (report.samples == 0) report.first_sample_s = host_seconds();
  report.samples += unit.path_count();
  report.rays.camera += result.rays.camera;
  report.rays.scattered += result.rays.scattered;
  report.rays.shadow += result.rays.shadow;
  report.nonfinite += result.nonfinite;
  report.saturated += result.saturated;
  for (const RejectedSample& sample : result.rejected)
    if (report.rejected.size() < EK_REPORT_COUNT) report.rejected.push_back(sample);
}

/// Where devices wait for each other between plans; the last to come looks at the film.
class Looker {
 public:
  Looker(const Looks& looks, Shared& shared) : looks_(looks), shared_(shared) {}
  void operator()() noexcept {
    const std::size_t done = plan_++;
    if (shared_.should_stop() || done >= looks_.at.size()) return;
    const std::lock_guard lock(shared_.mutex);
    try {
      double busy_s = 0;
      for (const DeviceReport& device : shared_.report.devices) busy_s = std::max(busy_s, device.busy_s);
      looks_.look(looks_.at[done], busy_s, shared_.state.film);
    } catch (...) {
      shared_.error = std::current_exception();
      shared_.failed = true;
    }
  }

 private:
  const Looks& looks_;
  Shared& shared_;
  std::size_t plan_ = 0;
};
using Rendezvous = std::barrier<Looker>;

/// One device: open, compile, upload, then units until there are none.
void drive(const DeviceInfo& info, const Job& job, Shared& shared, Rendezvous& rendezvous, DeviceReport& report) {
  const DevicePool::Lease lease = job.devices.take(info);
  Device& device = *lease;
  device.profiler().keep_spans(job.execution.keep_spans);
  Wavefront wavefront(device, job.scene, job.features, job.settings, job.execution);
  report.config = wavefront.config();
  report.arithmetic = wavefront.arithmetic();
  report.device_bytes = wavefront.device_bytes();
  for (std::size_t plan = 0; plan < shared.plans.size() && !shared.should_stop(); ++plan) {
    const double begin = host_seconds(), before_s = report.busy_s;
    // The device works on the next unit while the host adds the last one to the film.
    const auto begin_next = [&]() -> std::optional<WorkUnit> {
      if (shared.should_stop()) return std::nullopt;
      const std::uint64_t index = shared.next_unit[plan].fetch_add(1);
      if (index >= shared.plans[plan].size()) return std::nullopt;
      const WorkUnit unit = shared.plans[plan][index];
      wavefront.begin(unit);
      return unit;
    };
    for (std::optional<WorkUnit> unit = begin_next(); unit;) {
      const UnitResult result = wavefront.finish();
      const WorkUnit done = *std::exchange(unit, begin_next());
      merge(shared, result, done, report.arithmetic.name());
      report.samples += done.path_count();
      ++report.units;
      report.busy_s = before_s + host_seconds() - begin;
    }
    if (shared.plans.size() > 1) rendezvous.arrive_and_wait();
  }
  report.compile_s = device.profiler().compile_s;
  report.upload_s = wavefront.upload_s();
  report.stages = device.profiler().totals();
  report.spans = device.profiler().spans();
}

/// What is left of the range of samples, cut where the film is to be looked at.
std::vector<Plan> plans_between(const Looks& looks, const SampleLedger& done, const Settings& settings,
                                std::uint32_t block, std::uint32_t capacity) {
  std::vector<Plan> plans;
  std::uint64_t begin = settings.sample_begin;
  const auto add = [&](std::uint64_t end) {
    Plan& plan = plans.emplace_back();
    for (const WorkUnit& box : done.missing(settings.crop, begin, end))
      plan.add(UnitPlan(box.block, box.sample_begin, box.sample_end, block, capacity));
    begin = end;
  };
  for (const std::uint64_t end : looks.at) {
    if (end <= begin || end > settings.sample_end) throw InternalError("looks out of order, or beyond the samples");
    add(end);
  }
  if (begin < settings.sample_end) add(settings.sample_end);
  return plans;
}

/// Hands copies of the film to the hook, when they are due.
class Checkpoints {
 public:
  explicit Checkpoints(const RenderHooks& hooks) : hooks_(hooks), next_s_(host_seconds() + hooks.checkpoint_every_s) {}
  /// lock: of shared.mutex; let go while the hook works
  void call_if_due(Shared& shared, std::unique_lock<std::mutex>& lock, bool at_end) {
    if (!hooks_.checkpoint || shared.report.samples == samples_) return;
    const bool asked = hooks_.checkpoint_now != nullptr && hooks_.checkpoint_now->exchange(false);
    if (!asked && !at_end && host_seconds() < next_s_) return;
    const FilmState copy = shared.state;
    samples_ = shared.report.samples;
    lock.unlock();
    hooks_.checkpoint(copy);
    next_s_ = host_seconds() + hooks_.checkpoint_every_s;
    lock.lock();
  }

 private:
  const RenderHooks& hooks_;
  double next_s_;
  std::uint64_t samples_ = 0;
};

void thread_main(const DeviceInfo& info, const Job& job, Shared& shared, Rendezvous& rendezvous, DeviceReport& report) {
  try {
    drive(info, job, shared, rendezvous, report);
  } catch (...) {
    const std::lock_guard lock(shared.mutex);
    if (!shared.error) shared.error = std::current_exception();
    shared.failed = true;
  }
  rendezvous.arrive_and_drop();  // nobody waits for it any more
  const std::lock_guard lock(shared.mutex);
  --shared.running;
  shared.changed.notify_all();
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
  return layout;
}

namespace {

/// `pack` gives the PackedScene; it is called once it is certain that there are devices.
template <class Pack>
RenderOutput pack_and_render(const Pack& pack, const Features& features, const Settings& settings,
                             const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  const std::vector<DeviceInfo> devices = select_devices(execution.devices, execution.threads);
  const double pack_begin = host_seconds();
  auto&& packed = pack();
  const double pack_s = host_seconds() - pack_begin, built_before_s = packed.build_s;
  std::uint32_t capacity = ~0U;
  std::vector<Execution> executions(devices.size(), execution);  // with the layout that each device is to use
  std::vector<LayoutChoice> layouts;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& info = devices[i];
    layouts.push_back(choose_layout(info, packed, features, settings, execution));
    executions[i].layout = layouts[i].layout;
    const WavefrontConfig config = configure(info, executions[i]);
    capacity = std::min(capacity, config.capacity());
    require_memory(memory_need(packed, config, features), info, execution);
  }

  FilmState begin = hooks.begin_with ? std::move(*hooks.begin_with)
                                     : FilmState{Film(film_layout(features, settings)), SampleLedger()};
  if (begin.film.layout() != film_layout(features, settings))
    throw InternalError("a render goes on with a film of other layout");
  const std::uint64_t samples_before = begin.done.sample_count();
  const std::vector<Plan> plans = plans_between(hooks.looks, begin.done, settings, execution.block, capacity);
  Shared shared(plans, stop, std::move(begin));
  shared.report.devices.resize(devices.size());
  shared.report.samples_before = samples_before;
  shared.running = devices.size();

  DevicePool own_devices;
  DevicePool& pool = hooks.devices != nullptr ? *hooks.devices : own_devices;
  Rendezvous rendezvous(std::ptrdiff_t(devices.size()), Looker(hooks.looks, shared));
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < devices.size(); ++i) {
      shared.report.devices[i].info = devices[i];
      shared.report.devices[i].layout = layouts[i];
      threads.emplace_back([&, i] {
        const Job job{packed, features, settings, executions[i], pool};
        thread_main(devices[i], job, shared, rendezvous, shared.report.devices[i]);
      });
    }
    std::unique_lock lock(shared.mutex);
    std::uint64_t total = 0;
    for (const WorkUnit& box : shared.state.done.missing(settings.crop, settings.sample_begin, settings.sample_end))
      total += box.path_count();
    Checkpoints checkpoints(hooks);
    const std::chrono::duration<double> look_again(hooks.checkpoint ? std::clamp(hooks.checkpoint_every_s, 0.01, 0.25)
                                                                    : 0.25);
    try {
      while (shared.running > 0) {
        shared.changed.wait_for(lock, look_again);
        checkpoints.call_if_due(shared, lock, shared.running == 0);
        if (!hooks.progress || shared.report.samples == 0 || shared.running == 0) continue;
        Progress now;
        now.samples = shared.report.samples;
        now.samples_total = total;
        now.seconds = host_seconds() - shared.report.first_sample_s;
        now.samples_per_second = now.seconds > 0 ? double(now.samples) / now.seconds : 0;
        hooks.progress(now, shared.state.film);
      }
    } catch (...) {
      shared.failed = true;  // the devices' threads end before what they use goes
      throw;
    }
  }
  if (shared.error) std::rethrow_exception(shared.error);

  RenderReport& report = shared.report;
  for (const DeviceReport& device : report.devices) {
    report.compile_s = std::max(report.compile_s, device.compile_s);
    report.upload_s = std::max(report.upload_s, device.upload_s);
    report.render_s = std::max(report.render_s, device.busy_s);
  }
  report.interrupted = !shared.state.done.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
  report.features = features.summary();
  report.triangles = packed.triangles.size();
  report.geometry_bytes = packed.bytes(report.devices.front().config.layout);
  const auto tree = packed.accels.find(report.devices.front().config.layout);
  report.reinserted = tree != packed.accels.end() && tree->second.reinserted;
  report.pack_s = pack_s;
  report.build_s = packed.build_s - built_before_s;
  return {std::move(shared.state.film), std::move(report), std::move(shared.state.done),
          std::move(shared.state.arithmetic)};
}

}  // namespace

RenderOutput render(const Scene& scene, const Settings& settings, const Execution& execution,
                    const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features(scene, settings);
  const auto pack = [&] { return pack_scene(scene, features, settings); };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_and_release(Scene& scene, const Settings& settings, const Execution& execution,
                                const std::atomic<bool>& stop, RenderHooks hooks) {
  const Features features(scene, settings);
  const auto pack = [&] { return pack_and_release(scene, features, settings); };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

RenderOutput render_packed(PackedScene& packed, const Features& features, const Settings& settings,
                           const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks) {
  const auto pack = [&]() -> PackedScene& { return packed; };
  return pack_and_render(pack, features, settings, execution, stop, std::move(hooks));
}

glm::vec3 replay_path(const Scene& scene, const Settings& settings, const Execution& usual, std::uint32_t x,
                      std::uint32_t y, std::uint64_t sample, const std::function<void(const PathVertex&)>& report) {
  Execution execution = usual;
  execution.fused = false;
  const DeviceInfo info = select_devices(execution.devices, execution.threads).front();
  const Features features(scene, settings);
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
