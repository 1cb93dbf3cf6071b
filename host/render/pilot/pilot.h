// SPDX-License-Identifier: Apache-2.0
// The pilot: a small render before the render, which decides how many light paths the image has, and from which path
// guiding learns where light comes from, and whether it pays. It depends on the scene, the camera and the settings alone,
// so all parts of an image make the same one.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "guide/guide_table.h"
#include "render/ready_wavefronts.h"

namespace eikon {

/// The result of a pilot, for reports.
struct PilotReport {
  std::uint64_t paths = 0;  // that learned where light comes from; 0: none
  std::uint64_t cells = 0;
  double seconds = 0;
  /// Predicted product of error and rays without guiding over the same with it.
  double gain = 0;
  std::uint32_t roulette_depth = 0;     // GuideTable's; 0: paths are not guided
  std::uint64_t digest = 0;             // of the table
  std::uint64_t light_trial_paths = 0;  // from the camera, of the trial of light paths; 0: there was none
  std::uint64_t light_path_count = 0;   // for which it decided, of each sample index
  /// Predicted product of error and cost without light paths over that with them; 0 if only they find some light.
  double light_path_gain = 0;
  std::string arithmetic{};  // class of the device that rendered it
  bool loaded = false;       // it was known before the render
  bool cut_short = false;    // the render ended before it did
  [[nodiscard]] bool exists() const { return paths > 0 || light_trial_paths > 0; }
};

struct Pilot {
  std::shared_ptr<const GuideTable> table;  // null: paths are not guided
  PilotReport report;
};

inline constexpr std::uint64_t kMostPilotPaths = 1U << 19;
inline constexpr std::uint32_t kMostPilotPool = 1U
                                                << 17;  // most paths of a unit, which bounds the memory of their logs

/// The number of paths of the pilot of an image, for Settings::pilot_paths; 0: it has none, because it would not pay. It
/// follows from the size of the picture and not from the number of samples: a sample must not depend on how many
/// others are asked for.
[[nodiscard]] std::uint64_t usual_pilot_paths(const Settings& settings);
/// The number of paths from the camera of the trial of an image's light paths, for Settings::light_trial_paths; 0: there
/// is none, because the image is small.
[[nodiscard]] std::uint64_t usual_light_trial_paths(const Settings& settings);
/// Returns true if there is something in the scene that the pilot of the settings could decide or guide.
[[nodiscard]] bool wants_pilot(const Features& features, const Settings& settings);

/// Changes what an image is rendered with by what a pilot of it found.
void apply(const Pilot& pilot, Features& features, Settings& settings);

/// Told of the units of a pilot, by the thread that renders it. What begin_unit() throws ends the pilot.
class PilotSteps {
 public:
  PilotSteps() = default;
  PilotSteps(const PilotSteps&) = delete;
  PilotSteps& operator=(const PilotSteps&) = delete;
  virtual ~PilotSteps() = default;
  virtual void begin_unit(std::uint64_t /*paths*/) {}
  virtual void end_unit() {}
};

/// Renders the pilot. Its wavefront stays with the device, as DeviceGuest. throws DeviceError
[[nodiscard]] Pilot run_pilot(DevicePool::Lease& device, const ReadyWavefronts::SharedScene& scene,
                              const Features& features, const Settings& settings, const Execution& execution,
                              PilotSteps& steps);

}  // namespace eikon
