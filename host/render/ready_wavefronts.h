// SPDX-License-Identifier: Apache-2.0
// Wavefronts that stay with their device from one render to the next: program, scene and buffers in place.
#pragma once
#include <list>
#include <memory>
#include <string>

#include "device/device_pool.h"
#include "wavefront/wavefront.h"

namespace eikon {

class ReadyWavefronts : public DeviceGuest {
 public:
  /// What a wavefront is of, and must outlive it.
  struct Of {
    std::shared_ptr<const PackedScene> packed;
    std::shared_ptr<const void> keep;  // what `packed` refers to
  };

  /// All that a wavefront's program and buffers depend on, beside scene and device.
  [[nodiscard]] static std::string key_of(const Features& features, const Settings& settings,
                                          const Execution& execution);
  /// The wavefronts that stayed with a device, or none yet.
  [[nodiscard]] static ReadyWavefronts& of(DevicePool::Lease& lease);
  /// One for an image: restarted if a render of the same scene with the same needs left one, else made. It lives as long as the lease,
  /// or until the next call. throws DeviceError
  Wavefront& get(Device& device, const Of& of, const Features& features, const Settings& settings,
                 const Execution& execution);
  [[nodiscard]] std::size_t count() const { return ready_.size(); }

 private:
  struct Ready {
    Of of;
    std::string key;
    std::unique_ptr<Wavefront> wavefront;  // ends first
  };
  std::list<Ready> ready_;  // the one used last at the end

  void make_room(const Device& device, const Execution& execution);
};

}  // namespace eikon
