// SPDX-License-Identifier: Apache-2.0
// Devices that stay open from one render to the next, with the programs that they have compiled.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "device/device.h"

namespace eikon {

/// What stays with a device from one lease to the next, and ends before the device does.
struct DeviceGuest {
  DeviceGuest() = default;
  DeviceGuest(const DeviceGuest&) = delete;
  DeviceGuest& operator=(const DeviceGuest&) = delete;
  virtual ~DeviceGuest() = default;
};

/// Copies are one and the same pool.
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
    /// Whoever has the lease may put one there, and finds what those before left.
    [[nodiscard]] std::unique_ptr<DeviceGuest>& guest() { return guest_; }
    /// It failed: whoever takes it next opens it anew.
    void discard() { broken_ = true; }

   private:
    friend class DevicePool;
    struct Idle;
    Lease(std::shared_ptr<Idle> pool, std::unique_ptr<Device> device, std::unique_ptr<DeviceGuest> guest);
    std::shared_ptr<Idle> pool_;  // not of the DevicePool alone: a device that hangs may come back after its end
    std::unique_ptr<Device> device_;
    std::unique_ptr<DeviceGuest> guest_;  // ends before device_
    int exceptions_;
    bool broken_ = false;
  };

  /// One that is idle, else it is opened; its profiler is fresh. Any thread. throws DeviceError
  [[nodiscard]] Lease take(const DeviceInfo& info);
  /// select_devices(), asked once for each choice: devices that have been lost stay lost, and planned faults go on where they were.
  /// Those that were given up are left out, with a note for each. throws UsageError; DeviceError, also when none is left
  [[nodiscard]] std::vector<DeviceInfo> select(const std::string& selection, unsigned threads,
                                               std::vector<std::string>* notes = nullptr);
  /// A device that hangs in its driver: select() leaves it out from now on.
  void give_up(const DeviceInfo& info, const std::string& why);
  /// A pool of other devices that is one with this in what select() gives.
  [[nodiscard]] DevicePool sibling() const;
  /// Closes those that are idle, with their guests.
  void close_idle();
  /// How many are open and idle.
  [[nodiscard]] std::size_t idle_count() const;

 private:
  struct Selections;
  explicit DevicePool(std::shared_ptr<Selections> selections);
  std::shared_ptr<Selections> selections_;
  std::shared_ptr<Lease::Idle> idle_;
};

}  // namespace eikon
