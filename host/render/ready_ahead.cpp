// SPDX-License-Identifier: Apache-2.0
#include "render/ready_ahead.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "core/lost_threads.h"
#include "device/fault.h"
#include "wavefront/layout/choose_layout.h"
#include "render/crew.h"
#include "wavefront/memory.h"

namespace eikon {
namespace {

constexpr std::size_t kKnown = 8;  // images of a lane that are remembered; ReadyWavefronts keeps no more
constexpr std::uint64_t kMemoryShare =
    16;  // of a device's memory, that an image may take beside the one that is rendered

std::string key_of(const ReadyAhead::Image& image) {
  return fmt::format("{} {} {}\n{}", static_cast<const void*>(image.packed.get()), image.execution.devices,
                     image.execution.threads, ReadyWavefronts::key_of(image.features, image.settings, image.execution));
}

/// Whether limits and tests leave room for more than the render that is under way.
bool is_allowed(const Execution& execution) {
  return execution.memory_bytes == 0 && execution.threads == 0 && execution.layout != kProbeLayouts;
}

/// What the thread that makes devices ready shares with the one that waits for it, and may outlive.
struct Work {
  const ReadyAhead::Image image;
  DevicePool pool;
  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false, lost = false;
  std::optional<DeviceInfo> at{};  // the device in hand

  Work(ReadyAhead::Image of, DevicePool from) : image(std::move(of)), pool(std::move(from)) {}
};

void make_ready(Work& work) {
  const ReadyAhead::Image& image = work.image;
  for (const DeviceInfo& info : work.pool.select(image.execution.devices, image.execution.threads)) {
    if (info.fault && !info.fault->is_harmless()) return;
    {
      const std::lock_guard lock(work.mutex);
      if (work.lost) return;
      work.at = info;
    }
    Execution own = image.execution;
    own.trace = nullptr;  // a job's timeline has what happens in its turn
    own.layout = choose_layout(info, *image.packed, image.features, image.settings, own).layout;
    const MemoryNeed need = memory_need(*image.packed, configure(info, own), image.features);
    if (need.total() > info.memory_bytes / kMemoryShare) return;
    DevicePool::Lease lease = work.pool.take(info);
    // A CPU device may be one and the same for all contexts: commands would wait for units that are under way, one by one.
    if (info.cpu)
      Wavefront::compile_ahead(*lease, *image.packed, image.features, own);
    else
      (void)ReadyWavefronts::of(lease).get(*lease, {image.packed, image.keep}, image.features, image.settings, own);
  }
}

/// On a thread of its own: drivers may hang.
void make_ready_within(const std::shared_ptr<Work>& work, double seconds, const std::atomic<bool>& stop) {
  std::thread thread([work] {
    try {
      make_ready(*work);
    } catch (...) {
      // The render meets it too, and says so.
    }
    const std::lock_guard lock(work->mutex);
    work->ended = true;
    if (work->lost) lost_thread_ended();
    work->changed.notify_all();
  });
  std::unique_lock lock(work->mutex);
  const double until_s = host_seconds() + seconds;
  while (!work->ended && !stop && host_seconds() < until_s)
    work->changed.wait_for(lock, std::chrono::milliseconds(50));  // a signal wakes nobody
  if (work->ended) {
    lock.unlock();
    return thread.join();
  }
  work->lost = true;
  thread_is_lost();
  if (!stop && work->at)
    work->pool.give_up(*work->at, fmt::format("opening it did not end within {:.3g} s: it was given up", seconds));
  thread.detach();
}

}  // namespace

ReadyAhead::ReadyAhead(const DevicePool& pool) {
  for (Lane& lane : lanes_) lane.pool = pool.sibling();
}

/// The lane for an image. prepare: whether it is to be made ready there
std::size_t ReadyAhead::choose(const Image& image, const std::string& key, bool& prepare) {
  const auto has = [&](const Lane& lane) { return std::ranges::find(lane.ready, key) != lane.ready.end(); };
  const std::size_t other = 1 - last_;
  prepare = false;
  if (has(lanes_[last_])) return last_;
  if (has(lanes_[other])) return other;
  // A scene that is being rendered may get trees of other layouts meanwhile.
  const bool alone = turns_ == 0 || packed_ == nullptr || packed_ == image.packed.get();
  if (alone || !is_allowed(image.execution)) return last_;
  prepare = true;
  return other;
}

std::unique_ptr<ReadyAhead::Turn> ReadyAhead::turn(const Image& image, const std::atomic<bool>& stop) {
  const std::string key = key_of(image);
  bool prepare = false;
  std::unique_lock lock(mutex_);
  last_ = choose(image, key, prepare);
  packed_ = image.packed.get();
  Lane& lane = lanes_[last_];
  std::erase(lane.ready, key);
  lane.ready.push_back(key);
  if (lane.ready.size() > kKnown) lane.ready.pop_front();
  while (prepare && told_ < turns_ && !stop) changed_.wait_for(lock, std::chrono::milliseconds(50));
  ++turns_;
  auto turn = std::make_unique<Turn>(*this, lane.pool);
  lock.unlock();
  if (prepare && !stop)
    make_ready_within(std::make_shared<Work>(image, turn->pool()), Crew::kOpening * image.execution.watchdog_s, stop);
  return turn;
}

std::unique_ptr<ReadyAhead::Turn> ReadyAhead::turn() {
  const std::lock_guard lock(mutex_);
  packed_ = nullptr;
  ++turns_;
  return std::make_unique<Turn>(*this, lanes_[last_].pool);
}

void ReadyAhead::Turn::under_way() {
  const std::lock_guard lock(of_.mutex_);
  if (!std::exchange(told_, true)) ++of_.told_;
  of_.changed_.notify_all();
}

void ReadyAhead::close_idle() {
  const std::lock_guard lock(mutex_);
  for (Lane& lane : lanes_) {
    lane.pool.close_idle();
    lane.ready.clear();
  }
}

}  // namespace eikon
