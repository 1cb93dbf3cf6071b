// SPDX-License-Identifier: Apache-2.0
#include "device/device_pool.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "core/error.h"

namespace eikon {

struct DevicePool::Lease::Idle {
  struct Kept {
    std::unique_ptr<Device> device;
    std::unique_ptr<DeviceGuest> guest;  // destroyed before the device
  };
  explicit Idle(std::shared_ptr<Selections> of) : selections(std::move(of)) {}
  const std::shared_ptr<Selections> selections;
  std::mutex mutex;
  std::vector<Kept> devices;
};

struct DevicePool::Selections {
  struct Selected {
    std::vector<DeviceInfo> devices;
    std::vector<std::string> notes;
  };
  struct Lost {
    DeviceInfo info;
    std::string why;
  };
  std::mutex mutex;
  std::map<std::pair<std::string, unsigned>, Selected> selected;
  std::vector<Lost> lost;
  std::vector<std::weak_ptr<Lease::Idle>> pools;  // which are siblings

  void add(const std::shared_ptr<Lease::Idle>& pool) {
    const std::lock_guard lock(mutex);
    std::erase_if(pools, [](const auto& known) { return known.expired(); });
    pools.push_back(pool);
  }
};

namespace {

bool same_device(const DeviceInfo& a, const DeviceInfo& b) {
  return a.index == b.index && a.cpu == b.cpu && a.platform == b.platform && a.name == b.name &&
         a.first_unit == b.first_unit && a.compute_units == b.compute_units;
}

/// True if a device that was opened as the first can serve as the second.
bool can_serve(const DeviceInfo& open, const DeviceInfo& wanted) {
  return same_device(open, wanted) && (open.timed || !wanted.timed);
}

}  // namespace

DevicePool::Lease::Lease(std::shared_ptr<Idle> pool, std::unique_ptr<Device> device, std::unique_ptr<DeviceGuest> guest)
    : pool_(std::move(pool)),
      device_(std::move(device)),
      guest_(std::move(guest)),
      exceptions_(std::uncaught_exceptions()) {}

DevicePool::Lease::Lease(Lease&&) noexcept = default;

DevicePool::Lease::~Lease() {
  if (device_ == nullptr || broken_ || std::uncaught_exceptions() > exceptions_) return;
  const std::lock_guard lock(pool_->mutex);
  pool_->devices.push_back({std::move(device_), std::move(guest_)});
}

void DevicePool::Lease::hold_idle_to(std::uint64_t bytes) {
  std::vector<std::weak_ptr<Idle>> pools;
  {
    const std::lock_guard lock(pool_->selections->mutex);
    pools = pool_->selections->pools;
  }
  std::vector<Idle::Kept> closed;  // when no pool is locked
  std::uint64_t held = 0;
  for (const std::weak_ptr<Idle>& one : pools) {
    const std::shared_ptr<Idle> pool = one.lock();
    if (pool == nullptr) continue;
    const std::lock_guard lock(pool->mutex);
    std::erase_if(pool->devices, [&](Idle::Kept& kept) {
      if (kept.guest == nullptr || kept.device->info().index != device_->info().index) return false;
      const std::uint64_t own = kept.guest->device_bytes();
      const bool closes = own > 0 && held + own > bytes;
      if (closes) closed.push_back(std::move(kept));
      held += closes ? 0 : own;
      return closes;
    });
  }
}

DevicePool::DevicePool() : DevicePool(std::make_shared<Selections>()) {}
DevicePool::DevicePool(std::shared_ptr<Selections> selections)
    : selections_(std::move(selections)), idle_(std::make_shared<Lease::Idle>(selections_)) {
  selections_->add(idle_);
}
DevicePool DevicePool::sibling() const { return DevicePool(selections_); }

DevicePool::Lease DevicePool::take(const DeviceInfo& info) {
  Lease::Idle::Kept kept;
  {
    const std::lock_guard lock(idle_->mutex);
    const auto found = std::find_if(idle_->devices.begin(), idle_->devices.end(),
                                    [&](const auto& idle) { return can_serve(idle.device->info(), info); });
    if (found != idle_->devices.end()) {
      kept = std::move(*found);
      idle_->devices.erase(found);
    }
  }
  if (kept.device != nullptr)
    kept.device->profiler() = Profiler();
  else
    kept.device = std::make_unique<Device>(info);
  return {idle_, std::move(kept.device), std::move(kept.guest)};
}

std::vector<DeviceInfo> DevicePool::select(const std::string& selection, unsigned threads,
                                           std::vector<std::string>* notes) {
  const std::lock_guard lock(selections_->mutex);
  auto found = selections_->selected.find({selection, threads});
  if (found == selections_->selected.end()) {
    Selections::Selected selected;
    selected.devices = select_devices(selection, threads, &selected.notes);
    found = selections_->selected.emplace(std::pair(selection, threads), std::move(selected)).first;
  }
  std::vector<DeviceInfo> devices;
  std::vector<std::string> left_out;
  for (const DeviceInfo& info : found->second.devices) {
    const auto lost = std::ranges::find_if(
        selections_->lost, [&](const Selections::Lost& device) { return same_device(device.info, info); });
    if (lost == selections_->lost.end())
      devices.push_back(info);
    else
      left_out.push_back(fmt::format("device {} is used no more: {}", info.selector, lost->why));
  }
  if (devices.empty()) throw DeviceError(fmt::format("{}; start again", fmt::join(left_out, "; ")));
  if (notes != nullptr) {
    *notes = found->second.notes;
    notes->insert(notes->end(), left_out.begin(), left_out.end());
  }
  return devices;
}

void DevicePool::abandon(const DeviceInfo& info, const std::string& why) {
  const std::lock_guard lock(selections_->mutex);
  const auto known = [&](const Selections::Lost& device) { return same_device(device.info, info); };
  if (std::ranges::none_of(selections_->lost, known)) selections_->lost.push_back({info, why});
}

void DevicePool::close_idle() {
  std::vector<Lease::Idle::Kept> idle;
  const std::lock_guard lock(idle_->mutex);
  idle.swap(idle_->devices);
}

std::size_t DevicePool::idle_count() const {
  const std::lock_guard lock(idle_->mutex);
  return idle_->devices.size();
}

}  // namespace eikon
