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
  /// The scene of a wavefront. It keeps alive what it refers to.
  using SharedScene = std::shared_ptr<const PackedScene>;

  /// A text of everything that a wavefront's program and buffers depend on, except scene and
  /// device.
  [[nodiscard]] static std::string key_of(const Features& features, const Settings& settings,
                                          const Execution& execution);
  /// The wavefronts that stayed with a device, or none yet.
  [[nodiscard]] static ReadyWavefronts& of(DevicePool::Lease& lease);
  /// A wavefront for an image. It is restarted if a render of the same scene with the same needs
  /// left one, takes the scene if it fits one that is not needed any more, and is made else. It
  /// lives as long as the lease, or until the next call. Others that have room beside it stay, here
  /// and with idle devices. throws DeviceError
  /// lease  of these wavefronts
  Wavefront& get(DevicePool::Lease& lease, const SharedScene& scene, const Features& features, const Settings& settings,
                 const Execution& execution);
  /// True if get() would find a wavefront that has the program.
  [[nodiscard]] bool has_program(const PackedScene& packed, const Features& features,
                                 const Settings& settings, const Execution& execution) const;
  [[nodiscard]] std::size_t count() const { return ready_.size(); }
  [[nodiscard]] std::uint64_t device_bytes() const override;

 private:
  struct Ready {
    SharedScene scene;
    std::string key;
    std::unique_ptr<Wavefront> wavefront;  // destroyed before its scene
  };
  std::list<Ready> ready_;  // in the order of their last use

  [[nodiscard]] bool is_last_holder(const SharedScene& scene) const;
  /// A wavefront that may take another scene, and that suits it, or end().
  [[nodiscard]] std::list<Ready>::iterator find_fitting(const Device& device, const std::string& key,
                                                        const PackedScene& packed, const Features& features,
                                                        const Execution& execution);
  void leave_few(const Device& device, const Execution& execution);
  void make_room(DevicePool::Lease& lease, std::uint64_t need, const Execution& execution);
};

}  // namespace eikon
