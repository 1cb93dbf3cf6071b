// SPDX-License-Identifier: Apache-2.0
// One device's wavefront: its program, its buffers, and the order of the stages.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device/device.h"
#include "device/arithmetic.h"
#include "wavefront/bounces.h"
#include "pack/pack.h"
#include "wavefront/ray_census.h"
#include "pack/settings.h"
#include "film/units.h"
#include "wavefront/wavefront_config.h"

namespace eikon {

struct RejectedSample {
  std::uint32_t x = 0, y = 0;
  std::uint64_t sample = 0;
};

/// What a unit gave; the arrays belong to the wavefront: see Wavefront::finish.
struct UnitResult {
  UnitSums sums;
  RayCounts rays;
  std::uint64_t given_up = 0;           // rays that searched implicit surfaces
  std::uint32_t given_up_surfaces = 0;  // which: Diagnostics
  std::uint64_t nonfinite = 0, saturated = 0;
  std::vector<RejectedSample> rejected;  // the first few
};

/// The state of a single path between stages, for --pixel --sample.
struct PathVertex {
  std::uint32_t depth = 0;
  glm::vec3 origin, dir, beta;
  float t = 0;
  std::uint32_t triangle = 0;  // EK_NO_HIT: none
};

class Wavefront {
 public:
  /// Compiles and uploads. throws DeviceError
  Wavefront(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
            const Execution& execution);
  ~Wavefront();
  /// Compiles what one needs; the device keeps it for a while. No commands are sent to the device. throws DeviceError
  static void compile_ahead(Device& device, const PackedScene& scene, const Features& features,
                            const Execution& execution);
  /// As new for another image of the same scene: camera, seed, samples and depth may differ, but nothing that its program and its
  /// buffers depend on. What was begun must be finished.
  void restart(const Settings& settings, const Execution& execution);

  [[nodiscard]] const WavefrontConfig& config() const;
  /// What this device's arithmetic was found to be, with the program that renders.
  [[nodiscard]] ArithmeticClass arithmetic() const;
  [[nodiscard]] double upload_s() const;
  [[nodiscard]] std::uint64_t device_bytes() const;
  /// Of all units so far.
  [[nodiscard]] const Bounces& bounces() const;

  // Of a unit: begin(), drive(), finish(). The next one may begin between drive() and finish(): the device then has work while the host
  // waits for the sums and adds them up.

  /// Starts a unit of at most config().capacity() paths; of those begun at most one may not be finished, and that one is driven.
  /// throws DeviceError
  void begin(const WorkUnit& unit);
  /// Blocks until the device needs no more orders for the unit begun last, which may be at once. throws DeviceError
  void drive();
  /// Waits for the oldest unit that was begun. The result lasts until the next begin() but one. throws DeviceError; InternalError when a
  /// kernel reports one.
  UnitResult finish();

  /// Traces one path and reports its vertices. returns its radiance
  glm::vec3 replay(std::uint32_t x, std::uint32_t y, std::uint64_t sample,
                   const std::function<void(const PathVertex&)>& report);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
