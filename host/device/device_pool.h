// SPDX-License-Identifier: Apache-2.0
// Keeps devices open from one render to the next, with the programs that they have compiled.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "device/device.h"

namespace eikon {

/// An object that stays with a device from one lease to the next, and is destroyed before the
/// device.
struct DeviceGuest {
  DeviceGuest() = default;
  DeviceGuest(const DeviceGuest&) = delete;
  DeviceGuest& operator=(const DeviceGuest&) = delete;
  virtual ~DeviceGuest() = default;
  /// Memory of the device that it holds.
  [[nodiscard]] virtual std::uint64_t device_bytes() const { return 0; }
};

/// Copies share one pool.
class DevicePool {
 public:
  DevicePool();

  /// An open device for one render. Its destructor gives the device back to the pool, unless an
  /// exception was thrown meanwhile.
  class Lease {
   public:
    Lease(Lease&&) noexcept;
    Lease& operator=(Lease&&) = delete;
    ~Lease();
    Device& operator*() const { return *device_; }
    Device* operator->() const { return device_.get(); }
    /// The guest that an earlier lease left, if any; the holder may replace it.
    [[nodiscard]] std::unique_ptr<DeviceGuest>& guest() { return guest_; }
    /// Closes idle devices of this pool and its siblings until guests on the same hardware hold at
    /// most so many bytes.
    void hold_idle_to(std::uint64_t bytes);
    /// The device failed, so it does not go back to the pool.
    void discard() { broken_ = true; }

   private:
    friend class DevicePool;
    struct Idle;
    Lease(std::shared_ptr<Idle> pool, std::unique_ptr<Device> device, std::unique_ptr<DeviceGuest> guest);
    // Shared, because a device that hangs may come back after the pool's end.
    std::shared_ptr<Idle> pool_;
    std::unique_ptr<Device> device_;
    std::unique_ptr<DeviceGuest> guest_;  // destroyed before device_
    int exceptions_;
    bool broken_ = false;
  };

  /// Takes an idle device, or opens it; its profiler is reset. Any thread may call it. throws
  /// DeviceError
  [[nodiscard]] Lease take(const DeviceInfo& info);
  /// Calls select_devices() once for each choice and remembers the result, so that lost devices
  /// stay lost and planned faults continue. Abandoned devices are left out, with a note for each.
  /// throws UsageError; DeviceError, also when no device is left
  [[nodiscard]] std::vector<DeviceInfo> select(const std::string& selection, unsigned threads,
                                               std::vector<std::string>* notes = nullptr);
  /// The device hangs in its driver: select() leaves it out from now on.
  void abandon(const DeviceInfo& info, const std::string& why);
  /// Returns a pool that opens devices of its own but shares the selections and the abandoned
  /// devices.
  [[nodiscard]] DevicePool sibling() const;
  /// Closes idle devices and their guests.
  void close_idle();
  /// Returns the number of open, idle devices.
  [[nodiscard]] std::size_t idle_count() const;

 private:
  struct Selections;
  explicit DevicePool(std::shared_ptr<Selections> selections);
  std::shared_ptr<Selections> selections_;
  std::shared_ptr<Lease::Idle> idle_;
};

}  // namespace eikon
