// SPDX-License-Identifier: Apache-2.0
// Devices that stay open from one render to the next, with the programs that they have compiled.
#pragma once
#include <memory>

#include "device/device.h"

namespace eikon {

class DevicePool {
 public:
  DevicePool();

  /// An open device for one render; goes back to the pool at the end of its life, unless something was thrown meanwhile.
  class Lease {
   public:
    Lease(Lease&&) noexcept;
    Lease& operator=(Lease&&) = delete;
    ~Lease();
    Device& operator*() const { return *device_; }
    Device* operator->() const { return device_.get(); }
    /// It failed: whoever takes it next opens it anew.
    void discard() { broken_ = true; }

   private:
    friend class DevicePool;
    struct Idle;
    Lease(std::shared_ptr<Idle> pool, std::unique_ptr<Device> device);
    std::shared_ptr<Idle> pool_;  // not of the DevicePool alone: a device that hangs may come back after its end
    std::unique_ptr<Device> device_;
    int exceptions_;
    bool broken_ = false;
  };

  /// One that is idle, else it is opened; its profiler is fresh. Any thread. throws DeviceError
  [[nodiscard]] Lease take(const DeviceInfo& info);
  /// How many are open and idle.
  [[nodiscard]] std::size_t idle_count() const;

 private:
  std::shared_ptr<Lease::Idle> idle_;
};

}  // namespace eikon
