// SPDX-License-Identifier: Apache-2.0
#include "device/device_pool.h"

#include <algorithm>
#include <exception>
#include <mutex>

namespace eikon {

struct DevicePool::Lease::Idle {
  std::mutex mutex;
  std::vector<std::unique_ptr<Device>> devices;
};

namespace {

bool same_device(const DeviceInfo& a, const DeviceInfo& b) {
  return a.index == b.index && a.platform == b.platform && a.name == b.name && a.first_unit == b.first_unit &&
         a.compute_units == b.compute_units;
}

}  // namespace

DevicePool::Lease::Lease(std::shared_ptr<Idle> pool, std::unique_ptr<Device> device)
    : pool_(std::move(pool)), device_(std::move(device)), exceptions_(std::uncaught_exceptions()) {}

DevicePool::Lease::Lease(Lease&&) noexcept = default;

DevicePool::Lease::~Lease() {
  if (device_ == nullptr || broken_ || std::uncaught_exceptions() > exceptions_) return;
  const std::lock_guard lock(pool_->mutex);
  pool_->devices.push_back(std::move(device_));
}

DevicePool::DevicePool() : idle_(std::make_shared<Lease::Idle>()) {}

DevicePool::Lease DevicePool::take(const DeviceInfo& info) {
  std::unique_ptr<Device> device;
  {
    const std::lock_guard lock(idle_->mutex);
    const auto found = std::find_if(idle_->devices.begin(), idle_->devices.end(),
                                    [&](const auto& idle) { return same_device(idle->info(), info); });
    if (found != idle_->devices.end()) {
      device = std::move(*found);
      idle_->devices.erase(found);
    }
  }
  if (device != nullptr)
    device->profiler() = Profiler();
  else
    device = std::make_unique<Device>(info);
  return {idle_, std::move(device)};
}

std::size_t DevicePool::idle_count() const {
  const std::lock_guard lock(idle_->mutex);
  return idle_->devices.size();
}

}  // namespace eikon
