// SPDX-License-Identifier: Apache-2.0
// A unit under way on a device.
#pragma once
#include <cstdint>
#include <vector>

#include "wavefront/buffers.h"
#include "wavefront/light_stages.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// A unit under way, with the data that is being transferred to and from the device. There are two, so that the device
/// always has the next one.
struct UnitSlot {
  WorkUnit unit;
  Frame frame;
  Diagnostics nothing{}, diagnostics{};
  std::vector<std::uint32_t> pixels, sums, rejected, met;
  std::vector<WorkerTally> tallies;
  RayCounts rays;
  Kernel film;
  Ticket tallied, summed;
  LightUnit lights;

  /// Makes room for what the film stage leaves.
  void resize(const FilmShape& shape);
  /// What the unit brought, when all transfers have ended. Its arrays are those of this slot.
  [[nodiscard]] UnitResult result(const Mattes& mattes) const;
};

}  // namespace eikon
