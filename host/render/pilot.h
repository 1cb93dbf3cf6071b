// SPDX-License-Identifier: Apache-2.0
// The pilot: a small render before the render, from which path guiding learns where light comes from, and whether it
// pays. It depends on the scene, the camera and the settings alone, so all parts of an image make the same one.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "device/device.h"
#include "guide/guide_table.h"
#include "pack/pack.h"

namespace eikon {

/// The result of a pilot, for reports.
struct PilotReport {
  std::uint64_t paths = 0;  // 0: there was no pilot
  std::uint64_t cells = 0;
  double seconds = 0;
  /// Predicted product of error and rays without guiding over the same with it.
  double gain = 0;
  std::uint32_t roulette_depth = 0;  // GuideTable's; 0: paths are not guided
  std::uint64_t digest = 0;          // of the table
  std::string arithmetic{};          // class of the device that rendered it
  bool loaded = false;               // it was known before the render
  bool cut_short = false;            // the render ended before it did
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
/// Returns true if there is something in the scene that the pilot of the settings could guide.
[[nodiscard]] bool wants_pilot(const Features& features, const Settings& settings);

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

/// Renders the pilot. throws DeviceError
[[nodiscard]] Pilot run_pilot(Device& device, const PackedScene& packed, const Features& features,
                              const Settings& settings, const Execution& execution, PilotSteps& steps);

}  // namespace eikon
