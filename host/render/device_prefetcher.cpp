// SPDX-License-Identifier: Apache-2.0
#include "render/device_prefetcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "core/abandonable_task.h"
#include "core/clock.h"
#include "core/error.h"
#include "device/fault.h"
#include "render/device_sessions.h"
#include "render/device_worker.h"
#include "wavefront/layout/choose_layout.h"
#include "wavefront/memory_need.h"

namespace eikon {
namespace {

// Images of a pool that are remembered; ReadyWavefronts keeps no more.
constexpr std::size_t kMaxKnown = 8;
// An image may take one part in so many of a device's memory, beside the image that is being
// rendered.
constexpr std::uint64_t kPrefetchMemoryParts = 16;

/// Tells apart images that need other programs.
std::string program_of(const DevicePrefetcher::Image& image) {
  return fmt::format("{} {}\n{}", image.execution.devices, image.execution.threads,
                     ReadyWavefronts::key_of(image.features, image.settings, image.execution));
}

std::string key_of(const DevicePrefetcher::Image& image) {
  return fmt::format("{} {}", static_cast<const void*>(image.packed.get()), program_of(image));
}

/// Limits and tests leave room for more than the render that is under way.
bool is_allowed(const Execution& execution) {
  return execution.memory_bytes == 0 && execution.threads == 0 && execution.layout != kProbeLayouts;
}

/// State that the thread which makes devices ready shares with the thread that waits for it. The
/// former may outlive the latter.
struct Work {
  const DevicePrefetcher::Image image;
  DevicePool pool;
  const bool has_programs;  // only trees are to be made
  std::mutex mutex;         // guards all below
  bool is_abandoned = false;
  std::optional<DeviceInfo> at{};  // the device in hand

  Work(DevicePrefetcher::Image of, DevicePool from, bool programs)
      : image(std::move(of)), pool(std::move(from)), has_programs(programs) {}
};

void make_ready(Work& work) {
  const DevicePrefetcher::Image& image = work.image;
  for (const DeviceInfo& info : devices_of(work.pool, image.execution)) {
    if (info.fault && !info.fault->is_harmless()) return;
    {
      const std::lock_guard lock(work.mutex);
      if (work.is_abandoned) return;
      work.at = info;
    }
    Execution own = image.execution;
    own.trace = nullptr;  // the timeline of a job shows its own render only
    own.layout = choose_layout(info, *image.packed, image.features, image.settings, own).layout;
    own = fit_units(*image.packed, info, image.features, image.settings, own);  // as the render does, for the same key
    const MemoryNeed need = memory_need(*image.packed, configure(info, own), image.features, image.settings);
    if (need.total() > info.memory_bytes / kPrefetchMemoryParts) return;
    if (work.has_programs) continue;
    DevicePool::Lease lease = work.pool.take(info);
    // All contexts of a CPU device may share one queue, where commands would wait for each unit
    // that is under way. So nothing is uploaded to a CPU device; its programs are compiled.
    if (!info.cpu)
      (void)ReadyWavefronts::of(lease).get(lease, image.packed, image.features, image.settings, own);
    else if (!ReadyWavefronts::of(lease).has_program(*image.packed, image.features, image.settings, own))
      Wavefront::compile_ahead(*lease, *image.packed, image.features, own);
  }
}

/// Runs make_ready() on a thread of its own, because drivers may hang, and abandons it after so
/// many seconds.
void make_ready_within(const std::shared_ptr<Work>& work, double seconds, const std::atomic<bool>& stop) {
  AbandonableTask task([work] {
    try {
      make_ready(*work);
    } catch (...) {
      // The render meets the same error and reports it.
    }
  });
  const double until_s = host_seconds() + seconds;
  const auto gives_up = [&] {
    const std::lock_guard lock(work->mutex);
    work->is_abandoned = stop || host_seconds() >= until_s;
    return work->is_abandoned;
  };
  if (task.wait(gives_up)) return;
  const std::lock_guard lock(work->mutex);
  if (!stop && work->at)
    work->pool.abandon(*work->at, fmt::format("opening it did not end within {:.3g} s: it was given up", seconds));
}

}  // namespace

DevicePrefetcher::DevicePrefetcher(const DevicePool& pool) {
  for (PreparedPool& prepared : pools_) prepared.pool = pool.sibling();
}

DevicePrefetcher::Choice DevicePrefetcher::choose(const Image& image, const std::string& key) const {
  const auto has = [&](const PreparedPool& pool) { return std::ranges::find(pool.ready, key) != pool.ready.end(); };
  const std::size_t other = 1 - last_;
  if (has(pools_[last_])) return {last_, false};
  if (has(pools_[other])) return {other, false};
  // A scene that is being rendered may get trees of other layouts meanwhile.
  const bool alone = turns_ == 0 || packed_ == nullptr || packed_ == image.packed.get();
  if (alone || !is_allowed(image.execution)) return {last_, false};
  return {other, true};
}

bool DevicePrefetcher::has_only_cpus(const Image& image) {
  try {
    // The render before has selected the same devices, so that nothing is asked of a driver.
    return std::ranges::all_of(pools_[last_].pool.select(image.execution.devices, image.execution.threads),
                               [](const DeviceInfo& info) { return info.cpu && !info.fault; });
  } catch (const Error&) {
    return false;  // the render meets the same error and reports it
  }
}

std::unique_ptr<DevicePrefetcher::Turn> DevicePrefetcher::turn(const Image& image, const std::atomic<bool>& stop) {
  const std::string key = key_of(image), program = program_of(image);
  std::unique_lock lock(mutex_);
  Choice choice = choose(image, key);
  while (choice.prepare && under_way_ < turns_ && !stop) changed_.wait_for(lock, std::chrono::milliseconds(50));
  // Nothing is uploaded to CPU devices beforehand, so a second pool would only compile once more
  // what the first one has.
  const bool has_programs = choice.prepare && !stop && pools_[last_].program == program && has_only_cpus(image);
  if (has_programs) choice.pool = last_;
  last_ = choice.pool;
  packed_ = image.packed.get();
  PreparedPool& pool = pools_[last_];
  pool.program = program;
  std::erase(pool.ready, key);
  pool.ready.push_back(key);
  if (pool.ready.size() > kMaxKnown) pool.ready.pop_front();
  ++turns_;
  auto turn = std::make_unique<Turn>(*this, pool.pool);
  lock.unlock();
  if (choice.prepare && !stop)
    make_ready_within(std::make_shared<Work>(image, turn->pool(), has_programs),
                      DeviceSessions::kOpeningWatchdogs * image.execution.watchdog_s, stop);
  return turn;
}

std::unique_ptr<DevicePrefetcher::Turn> DevicePrefetcher::turn() {
  const std::lock_guard lock(mutex_);
  packed_ = nullptr;
  pools_[last_].program.clear();
  ++turns_;
  return std::make_unique<Turn>(*this, pools_[last_].pool);
}

void DevicePrefetcher::Turn::under_way() {
  const std::lock_guard lock(owner_.mutex_);
  if (!std::exchange(told_, true)) ++owner_.under_way_;
  owner_.changed_.notify_all();
}

void DevicePrefetcher::close_idle() {
  const std::lock_guard lock(mutex_);
  for (PreparedPool& prepared : pools_) {
    prepared.pool.close_idle();
    prepared.ready.clear();
    prepared.program.clear();
  }
}

}  // namespace eikon
