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

/// Names one sample of the image, for messages and to replay it.
struct PixelSample {
  std::uint32_t x = 0, y = 0;  // pixels of the full image
  std::uint64_t sample = 0;    // index
};

/// The result of a unit. The arrays belong to the wavefront: see Wavefront::finish.
struct UnitResult {
  UnitSums sums;
  RayCounts rays;                       // of all rays
  RayCounts light_rays;                 // of the rays of light paths, which `rays` includes
  std::uint64_t search_failures = 0;    // rays that exceeded the steps allowed in implicit surfaces
  std::uint32_t search_failure_surfaces = 0;  // the surfaces in which that happened, as RenderTotals has them
  std::uint64_t nonfinite = 0;          // samples and splats that were left out because they are NaN or infinite
  std::uint64_t saturated = 0;          // and those because they are beyond the film's range
  std::vector<PixelSample> rejected;    // the first few of both, without splats
};

/// Renders units of one image on one device. Only one thread may use it, and that may hang in a
/// call of the driver.
class Wavefront {
 public:
  /// Compiles the program, uploads the scene and allocates the buffers for paths in flight.
  /// scene  must outlive the wavefront, or live until change_scene() returns
  /// throws DeviceError
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
  /// True if its program and its work buffers suit another scene, whose features and execution are
  /// the same but for what depends on the scene alone.
  [[nodiscard]] bool fits(const PackedScene& scene, const Features& features, const Execution& execution) const;
  /// Prepares for an image of another scene that it fits, such as the next frame of a sequence: the
  /// scene is uploaded, and nothing is compiled. The scene before must live until this returns.
  /// After an error it must not be used any more. throws DeviceError
  void change_scene(const PackedScene& scene, const Features& features, const Settings& settings,
                    const Execution& execution);

  [[nodiscard]] const WavefrontConfig& config() const;
  /// The class of this device's arithmetic, measured with the program that renders.
  [[nodiscard]] ArithmeticClass arithmetic() const;
  [[nodiscard]] double upload_s() const;
  [[nodiscard]] std::uint64_t device_bytes() const;
  /// The counts of all units so far.
  [[nodiscard]] const Bounces& bounces() const;

  // Three calls render a unit: begin(), launch_rest(), finish(). The next unit may begin between
  // launch_rest() and finish() of the one before, so that the device has work while the host waits
  // for the sums and adds them up:
  //   begin(a), launch_rest(), begin(b), finish() -> a, launch_rest(), begin(c), finish() -> b, ...
  // If one launch runs all stages (WavefrontConfig::fused), begin() launches it and launch_rest()
  // does nothing. Otherwise begin() launches the first depth, and launch_rest() the others.

  /// Starts a unit of at most config().capacity() paths. One earlier unit may be unfinished, if
  /// launch_rest() was called for it. throws DeviceError; InternalError if the unit is too large,
  /// or has no place yet
  void begin(const WorkUnit& unit);
  /// Launches the other depths of the unit that was begun last, and its film stage. Waits for the
  /// number of paths that go on after each depth, so this blocks until the last depth is under way.
  /// throws DeviceError
  void launch_rest();
  /// Waits for the oldest unit that was begun, and calls launch_rest() for it if nobody did. The
  /// arrays of the result are valid until the next begin() but one. throws DeviceError;
  /// InternalError if no unit was begun
  UnitResult finish();

  /// Turns the light paths of units on or off, if the program has the stages for them. Each image
  /// begins with them.
  void trace_light_paths(bool on);
  /// Uploads another table of path guiding; of a program with feature path_log. No unit may be
  /// under way.
  void set_guide(std::shared_ptr<const GuideTable> guide);
  /// The log of the unit that was finished last, until the next begin(); of a program with feature
  /// path_log.
  [[nodiscard]] PathLog path_log();

  /// Traces the path of one sample of a pixel, and reports its vertices from the camera on.
  /// returns  the light that the path brings, and what the light paths of the same sample index
  ///          bring to the pixel, if Settings::crop is this pixel alone
  /// throws DeviceError; InternalError if one launch runs all stages
  ReplayedSample replay(std::uint32_t x, std::uint32_t y, std::uint64_t sample,
                        const std::function<void(const PathVertex&)>& report);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
