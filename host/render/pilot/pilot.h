// SPDX-License-Identifier: Apache-2.0
// The pilot is a small render before the image's own. It decides how many light paths the image
// has, learns where light comes from (path guiding), and decides whether paths are to follow that.
// It depends on the scene, the camera and the settings alone, so all parts of an image make the
// same one.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "guide/guide_table.h"
#include "guide/light_aim.h"
#include "render/ready_wavefronts.h"

namespace eikon {

/// The decisions of a pilot and their cost, for reports and for the file of --pilot.
struct PilotReport {
  double seconds = 0;
  std::string arithmetic{};  // the arithmetic class of the device that rendered the pilot
  bool loaded = false;       // the pilot comes from a file or an earlier job; it was not rendered for this image
  bool cut_short = false;    // the render was stopped, or out of time, before the pilot had ended

  // The trial of light paths (light_trial.h).
  std::uint64_t light_trial_paths = 0;  // camera paths of the trial; 0: there was no trial
  std::uint64_t light_path_count = 0;   // light paths of each sample index, as the trial decided
  double light_path_gain = 0;  // error times cost without light paths over that with them; 0: only they find some light
  double light_aim_gain = 0;   // of even starts, over that with those that were learned (LightAim); 0: they are even

  // Path guiding (guiding_pilot.h).
  std::uint64_t guiding_paths =
      0;  // traced to learn the table, with the 4 of each pixel before that; 0: nothing was learned
  std::uint64_t guiding_cells = 0;  // cells of that table
  // Error times rays without guiding over that with it; 1 where there is nothing to learn, or where
  // a few pixels have most of the error.
  double guiding_gain = 0;
  std::uint32_t roulette_depth = 0;  // GuideTable::roulette_depth; 0: paths are not guided
  std::uint64_t guiding_digest = 0;  // GuideTable::digest()
  [[nodiscard]] bool exists() const { return guiding_paths > 0 || light_trial_paths > 0; }
};

/// Holds what a pilot has learned and decided; apply() brings it into a render.
struct Pilot {
  std::shared_ptr<const GuideTable> table;    // null: paths are not guided
  std::shared_ptr<const LightAim> light_aim;  // null: light paths start evenly
  PilotReport report;
};

/// The most paths from which a table is learned.
inline constexpr std::uint64_t kMaxPilotPaths = 1U << 19;
/// The most paths of a unit of a pilot. It bounds the memory of their logs.
inline constexpr std::uint32_t kMaxPilotUnitPaths = 1U << 17;

/// The number of paths of the pilot of an image, for Settings::pilot_paths; 0: it has none, because
/// it would not pay. It follows from the size of the picture and not from the number of samples: a
/// sample must not depend on how many others are asked for.
[[nodiscard]] std::uint64_t usual_pilot_paths(const Settings& settings);
/// The number of paths from the camera of the trial of an image's light paths, for
/// Settings::light_trial_paths; 0: there is none, because the image is small.
/// light_paths_needed  some light is found by light paths alone (only_light_paths_find_some). Too
///                     few of them leave a few very bright pixels then, so that small images have a
///                     trial, too
[[nodiscard]] std::uint64_t usual_light_trial_paths(const Settings& settings, bool light_paths_needed);
/// Returns true if there is something in the scene that the pilot of the settings could decide or
/// guide.
[[nodiscard]] bool wants_pilot(const Features& features, const Settings& settings);

/// Writes what a pilot decided into the features and the settings that its image is rendered with.
void apply(const Pilot& pilot, Features& features, Settings& settings);

/// Is called around each unit of a pilot, on the thread that renders it. An exception of
/// begin_unit() ends the pilot.
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
