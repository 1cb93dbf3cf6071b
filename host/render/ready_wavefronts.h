// SPDX-License-Identifier: Apache-2.0
// Wavefronts that stay with their device from one render to the next: program, scene and buffers in
// place.
#pragma once
#include <list>
#include <memory>
#include <string>

#include "device/device_pool.h"
#include "wavefront/wavefront.h"

namespace eikon {

class ReadyWavefronts : public DeviceGuest {
 public:
  /// The scene of a wavefront, which must outlive it.
  struct SharedScene {
    std::shared_ptr<const PackedScene> packed;
    std::shared_ptr<const void> keep;  // owns what `packed` refers to
  };

  /// A text of everything that a wavefront's program and buffers depend on, except scene and
  /// device.
  [[nodiscard]] static std::string key_of(const Features& features, const Settings& settings,
                                          const Execution& execution);
  /// The wavefronts that stayed with a device, or none yet.
  [[nodiscard]] static ReadyWavefronts& of(DevicePool::Lease& lease);
  /// A wavefront for an image. It is restarted if a render of the same scene with the same needs
  /// left one, else made. It lives as long as the lease, or until the next call. throws DeviceError
  Wavefront& get(Device& device, const SharedScene& scene, const Features& features, const Settings& settings,
                 const Execution& execution);
  [[nodiscard]] std::size_t count() const { return ready_.size(); }

 private:
  struct Ready {
    SharedScene scene;
    std::string key;
    std::unique_ptr<Wavefront> wavefront;  // destroyed before its scene
  };
  std::list<Ready> ready_;  // in the order of their last use

  void make_room(const Device& device, const Execution& execution);
};

}  // namespace eikon
