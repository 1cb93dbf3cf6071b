// SPDX-License-Identifier: Apache-2.0
// Words of the host that transfers to and from a device use.
#pragma once
#include <bit>
#include <cstdint>
#include <memory>
#include <span>

#include "device/device.h"

namespace eikon {

/// An array in memory for transfers (Device::transfer_memory).
class TransferWords {
 public:
  /// Its words may be lost. No transfer may be under way. throws DeviceError
  void resize(Device& device, std::size_t size) {
    if (size > room_) {
      memory_.reset();
      room_ = std::bit_ceil(size);
      memory_ = device.transfer_memory(room_);
    }
    size_ = size;
  }
  [[nodiscard]] std::span<std::uint32_t> words() { return {memory_.get(), size_}; }
  [[nodiscard]] std::span<const std::uint32_t> words() const { return {memory_.get(), size_}; }
  [[nodiscard]] std::size_t size_bytes() const { return sizeof(std::uint32_t) * size_; }

 private:
  std::shared_ptr<std::uint32_t[]> memory_;
  std::size_t room_ = 0, size_ = 0;
};

}  // namespace eikon
