// SPDX-License-Identifier: Apache-2.0
// A unit that a device is at work on, and the memory that its transfers use meanwhile.
#pragma once
#include <cstdint>
#include <vector>

#include "wavefront/buffers.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/transfer_words.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// A unit between Wavefront::begin() and the end of its transfers. A wavefront has two, so that the
/// device has the next unit while the host waits for the sums of the one before.
struct UnitInFlight {
  std::size_t index = 0;  // among the two of the wavefront
  WorkUnit unit;
  // Memory that the device reads.
  Frame frame;
  TransferWords pixels;               // unit_pixels() of its block
  Diagnostics no_diagnostics{};       // zeros, with which the device's counters begin
  // Memory that the device writes; UnitSums describes the arrays.
  std::vector<std::uint32_t> sums, rejected, matte_numbers;
  TransferWords packed;  // instead of `sums`, unless some do not fit
  TransferWords diagnostics_words;
  Diagnostics diagnostics{};         // the same, once the unit has ended
  std::vector<WorkerTally> tallies;  // of each work-item, if one launch runs all stages

  Kernel film, pack_sums;  // bound to the buffers of this unit
  Ticket tallied;  // `tallies` are there
  Ticket summed;   // all else is there
  RayCounts rays;  // without those of light paths
  RayCounts photon_rays;  // of the maps that were made for this unit
  LightUnit lights;

  /// Makes room for the sums, counts and matte numbers of its pixels.
  void resize(Device& device, const FilmShape& shape, bool packs);
  /// The result of the unit, once all transfers have ended. Its arrays are the ones in here.
  [[nodiscard]] UnitResult result(const Mattes& mattes) const;
};

}  // namespace eikon
