// SPDX-License-Identifier: Apache-2.0
// One device's wavefront: its program, its buffers, and the order of the stages.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "device/device.h"
#include "device/probes.h"
#include "pack/pack.h"
#include "wavefront/ray_counters.h"
#include "pack/settings.h"
#include "film/units.h"
#include "guide/learner.h"
#include "wavefront/config.h"
#include "wavefront/replay.h"
#include "wavefront/tallies.h"

namespace eikon {

struct PixelSample {
  std::uint32_t x = 0, y = 0;
  std::uint64_t sample = 0;
};

/// The result of a unit. The arrays belong to the wavefront: see Wavefront::finish.
struct UnitResult {
  UnitSums sums;
  RayCounts rays, light_rays;           // light_rays: those of light paths among them
  std::uint64_t given_up = 0;           // rays that exceeded the steps allowed in implicit surfaces
  std::uint32_t given_up_surfaces = 0;  // in which surfaces: see Diagnostics
  std::uint64_t nonfinite = 0, saturated = 0;
  std::vector<PixelSample> rejected;  // the first few
};

/// sums, rays, diagnostics  of one unit
[[nodiscard]] UnitResult unit_result(const UnitSums& sums, const RayCounts& rays, const Diagnostics& diagnostics);

class Wavefront {
 public:
  /// Compiles and uploads. throws DeviceError
  Wavefront(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
            const Execution& execution);
  ~Wavefront();
  /// Compiles the program of such a wavefront, which the device keeps for a while. Nothing runs on
  /// the device.
  /// throws DeviceError
  static void compile_ahead(Device& device, const PackedScene& scene, const Features& features,
                            const Execution& execution);
  /// Prepares for another image of the same scene. Camera, seed, samples and depth may differ, but
  /// nothing that the program and the buffers depend on. All units that were begun must be
  /// finished.
  void restart(const Settings& settings, const Execution& execution);
  /// True if its program and its work buffers suit another scene, whose features and execution are the same but for what
  /// depends on the scene alone.
  [[nodiscard]] bool fits(const PackedScene& scene, const Features& features, const Execution& execution) const;
  /// Prepares for an image of another scene that it fits, such as the next frame of a sequence: the scene is uploaded, and
  /// nothing is compiled. The scene before must live until this returns. After an error it must not be used any more.
  /// throws DeviceError
  void change_scene(const PackedScene& scene, const Features& features, const Settings& settings,
                    const Execution& execution);

  [[nodiscard]] const WavefrontConfig& config() const;
  /// The class of this device's arithmetic, measured with the program that renders.
  [[nodiscard]] ArithmeticClass arithmetic() const;
  [[nodiscard]] double upload_s() const;
  [[nodiscard]] std::uint64_t device_bytes() const;
  /// The counts of all units so far.
  [[nodiscard]] const Bounces& bounces() const;

  // A unit is rendered by begin(), drive(), finish(). The next one may begin between drive() and
  // finish(), so that the device has work while the host waits for the sums and adds them up.

  /// Starts a unit of at most config().capacity() paths. At most one earlier unit may be
  /// unfinished, and that one is driven.
  /// throws DeviceError
  void begin(const WorkUnit& unit);
  /// Launches the rest of the unit that was begun last. Blocks while the host has to look at
  /// counts. throws DeviceError
  void drive();
  /// Waits for the oldest unit that was begun. The result lasts until the next begin() but one.
  /// throws DeviceError; InternalError when a kernel reports one
  UnitResult finish();

  /// Turns the light paths of units on or off, if the program has the stages for them. At first they are on.
  void trace_light_paths(bool on);
  /// Uploads another table of path guiding; of a program with feature path_log. No unit may be under way.
  void set_guide(std::shared_ptr<const GuideTable> guide);
  /// The log of the unit that was finished last, until the next begin(); of a program with feature path_log.
  [[nodiscard]] PathLog path_log();

  /// Traces one path, reports its vertices, and returns what it brings, and what light paths bring if the image is that
  /// pixel (Settings::crop).
  ReplayedSample replay(std::uint32_t x, std::uint32_t y, std::uint64_t sample,
                        const std::function<void(const PathVertex&)>& report);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
