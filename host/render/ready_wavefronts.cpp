// SPDX-License-Identifier: Apache-2.0
#include "render/ready_wavefronts.h"

#include <fmt/format.h>

#include <algorithm>

#include "wavefront/memory_need.h"

namespace eikon {
namespace {

// Wavefronts of a device; a batch may render several scenes in turn.
constexpr std::size_t kMost = 8;
// They take at most one part in so many of its memory while another is made.
constexpr std::uint64_t kMemoryParts = 8;
constexpr std::uint64_t kUnset = ~std::uint64_t{0};  // stands for what the device chooses

}  // namespace

std::string ReadyWavefronts::key_of(const Features& features, const Settings& settings, const Execution& execution) {
  const auto number = [](const auto& value) { return value ? std::uint64_t{*value} : kUnset; };
  std::string needs;  // names, with the numbers that some of them have
  for (const auto& [name, value] : features.defines()) needs += fmt::format("{}={} ", name, value);
  return fmt::format("{}\n{} {} {} {} {} {} {} {} {} {} {} {} {}\n{}", needs, settings.filter.name(),
                     settings.replicate_bits, execution.accel, execution.layout, number(execution.lanes),
                     number(execution.chunked), number(execution.fused), execution.chunk, execution.unit_paths,
                     execution.block, execution.memory_bytes, execution.ticks, execution.optimise,
                     execution.extra_flags);
}

ReadyWavefronts& ReadyWavefronts::of(DevicePool::Lease& lease) {
  auto* found = dynamic_cast<ReadyWavefronts*>(lease.guest().get());
  if (found == nullptr) {
    auto none = std::make_unique<ReadyWavefronts>();
    found = none.get();
    lease.guest() = std::move(none);
  }
  return *found;
}

/// True if only these wavefronts hold the scene, which then will not come again.
bool ReadyWavefronts::is_last_holder(const SharedScene& scene) const {
  return scene.use_count() <= std::ranges::count_if(ready_, [&](const Ready& ready) { return ready.scene == scene; });
}

std::uint64_t ReadyWavefronts::device_bytes() const {
  std::uint64_t sum = 0;
  for (const Ready& ready : ready_) sum += ready.wavefront->device_bytes();
  return sum;
}

/// Gives up what is not worth its memory while another wavefront is made.
void ReadyWavefronts::leave_few(const Device& device, const Execution& execution) {
  for (auto at = ready_.begin(); at != ready_.end();) at = is_last_holder(at->scene) ? ready_.erase(at) : std::next(at);
  // A memory limit is meant for one render.
  const std::size_t most = execution.memory_bytes != 0 ? 0 : kMost - 1;
  while (ready_.size() > most || (!ready_.empty() && device_bytes() > device.info().memory_bytes / kMemoryParts))
    ready_.pop_front();
}

/// Gives up what has no room on the device beside a wavefront that needs so many bytes: its units
/// were sized as if it were alone.
void ReadyWavefronts::make_room(DevicePool::Lease& lease, std::uint64_t need, const Execution& execution) {
  const std::uint64_t available = available_bytes(lease->info(), execution),
                      room = available - std::min(available, need);
  while (!ready_.empty() && device_bytes() > room) ready_.pop_front();
  lease.hold_idle_to(room - device_bytes());
}

std::list<ReadyWavefronts::Ready>::iterator ReadyWavefronts::find_fitting(const Device& device, const std::string& key,
                                                                          const PackedScene& packed,
                                                                          const Features& features,
                                                                          const Execution& execution) {
  // A CPU device reads scenes in place, so that one of them may come again for nothing.
  return std::ranges::find_if(ready_, [&](const Ready& ready) {
    return ready.key == key && (device.info().cpu || is_last_holder(ready.scene)) &&
           ready.wavefront->fits(packed, features, execution);
  });
}

bool ReadyWavefronts::has_program(const PackedScene& packed, const Features& features, const Settings& settings,
                                  const Execution& execution) const {
  const std::string key = key_of(features, settings, execution);
  return std::ranges::any_of(ready_, [&](const Ready& ready) {
    return ready.key == key && ready.wavefront->fits(packed, features, execution);
  });
}

Wavefront& ReadyWavefronts::get(DevicePool::Lease& lease, const SharedScene& scene, const Features& features,
                                const Settings& settings, const Execution& execution) {
  Device& device = *lease;
  const std::string key = key_of(features, settings, execution);
  const auto found = std::find_if(ready_.begin(), ready_.end(),
                                  [&](const Ready& ready) { return ready.scene == scene && ready.key == key; });
  if (found != ready_.end()) {
    ready_.splice(ready_.end(), ready_, found);
    found->wavefront->restart(settings, execution);
    return *found->wavefront;
  }
  const std::uint64_t need = memory_need(*scene, configure(device.info(), execution), features, settings).total() +
                             (settings.guide != nullptr ? settings.guide->bytes() : 0);
  if (const auto fitting = find_fitting(device, key, *scene, features, execution); fitting != ready_.end()) {
    std::list<Ready> one;  // which is lost with its wavefront after an error
    one.splice(one.end(), ready_, fitting);
    make_room(lease, need, execution);
    one.front().wavefront->change_scene(*scene, features, settings, execution);
    one.front().scene = scene;
    ready_.splice(ready_.end(), one);
  } else {
    leave_few(device, execution);
    make_room(lease, need, execution);
    ready_.push_back({scene, key, std::make_unique<Wavefront>(device, *scene, features, settings, execution)});
  }
  return *ready_.back().wavefront;
}

}  // namespace eikon
