// SPDX-License-Identifier: Apache-2.0
// The photons of one device: makes the maps of a generation of samples when the first unit needs
// them, and keeps them for the next ones.
#pragma once
#include <cstdint>
#include <optional>

#include "wavefront/photons/photon_map.h"
#include "wavefront/stages/light_stages.h"

namespace eikon {

class PhotonStage {
 public:
  PhotonStage() = default;
  /// Makes buffers without photons, and names them in `arguments`. throws DeviceError
  PhotonStage(Device& device, Arguments& arguments);
  /// Begins an image, of which no maps are there. frame: of it
  void restart(const PhotonPlan& plan, const Frame& frame);
  /// True if units of the image need maps.
  [[nodiscard]] bool exists() const { return device_ != nullptr && plan_.paths > 0; }
  /// Makes the maps of a unit's samples, unless they are there, and describes them in `frame`.
  /// Waits until the device has done all before.
  /// which   of LightStages::begin
  /// rays    receives those that were traced
  /// returns true if buffers in `arguments` are new, so that kernels must be bound again
  /// throws DeviceError; InternalError if the samples are of several generations
  bool prepare(LightStages& lights, std::size_t which, const WorkUnit& unit, Frame& frame, Arguments& arguments,
               RayCounts& rays);
  /// Device memory of the maps.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  Device* device_ = nullptr;
  PhotonPlan plan_;
  float first_radius2_ = 0;
  std::optional<std::uint64_t> generation_;  // whose maps are there
  LightUnit found_;                          // photons under way; after an error transfers may still use it
  PhotonMap map_;                            // the buffers of a CPU device may be its memory (Device::share)

  void share(Arguments& arguments);
};

}  // namespace eikon
