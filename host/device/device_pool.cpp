// SPDX-License-Identifier: Apache-2.0
#include "device/device_pool.h"

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <utility>

namespace eikon {

struct DevicePool::Lease::Idle {
  struct Kept {
    std::unique_ptr<Device> device;
    std::unique_ptr<DeviceGuest> guest;  // ends first
  };
  struct Selected {
    std::vector<DeviceInfo> devices;
    std::vector<std::string> notes;
  };
  std::mutex mutex;
  std::vector<Kept> devices;
  std::map<std::pair<std::string, unsigned>, Selected> selections;
};

namespace {

bool same_device(const DeviceInfo& a, const DeviceInfo& b) {
  return a.index == b.index && a.cpu == b.cpu && a.platform == b.platform && a.name == b.name &&
         a.first_unit == b.first_unit && a.compute_units == b.compute_units;
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

DevicePool::DevicePool() : idle_(std::make_shared<Lease::Idle>()) {}

DevicePool::Lease DevicePool::take(const DeviceInfo& info) {
  Lease::Idle::Kept kept;
  {
    const std::lock_guard lock(idle_->mutex);
    const auto found = std::find_if(idle_->devices.begin(), idle_->devices.end(),
                                    [&](const auto& idle) { return same_device(idle.device->info(), info); });
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
  const std::lock_guard lock(idle_->mutex);
  auto found = idle_->selections.find({selection, threads});
  if (found == idle_->selections.end()) {
    Lease::Idle::Selected selected;
    selected.devices = select_devices(selection, threads, &selected.notes);
    found = idle_->selections.emplace(std::pair(selection, threads), std::move(selected)).first;
  }
  if (notes != nullptr) *notes = found->second.notes;
  return found->second.devices;
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
