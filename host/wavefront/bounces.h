// SPDX-License-Identifier: Apache-2.0
// Occupancy of lanes and queues at each bounce.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "shared/records.h"

namespace eikon {

/// Rays that were traced at a depth, and the lanes and slots that were held for them.
struct Bounce {
  std::uint64_t paths = 0;        // that reached it: camera and scattered rays
  std::uint64_t shadow_rays = 0;  // cast there
  std::uint64_t lanes = 0;        // that ran, with or without a path: whole vectors of a chunk, or whole work-groups
  std::uint64_t slots = 0;        // of the chunks that still had paths, or of the whole pool
};

/// Indexed by depth - 1; the last entry sums up all deeper bounces.
using Bounces = std::array<Bounce, EK_TALLY_DEPTHS>;

inline Bounce& bounce_at(Bounces& bounces, std::uint32_t depth) {
  return bounces[depth < EK_TALLY_DEPTHS ? depth - 1 : EK_TALLY_DEPTHS - 1];
}

inline void add_bounces(Bounces& bounces, const Bounces& more) {
  for (std::size_t i = 0; i < bounces.size(); ++i) {
    bounces[i].paths += more[i].paths;
    bounces[i].shadow_rays += more[i].shadow_rays;
    bounces[i].lanes += more[i].lanes;
    bounces[i].slots += more[i].slots;
  }
}

/// Adds the counts of the work-items of a launch of kernel `paths`.
void add_bounces(Bounces& bounces, std::span<const WorkerTally> tallies, std::uint32_t width, std::uint32_t chunk);

/// Mean number of live paths in a chunk, over all bounces of all chunks; 0 if there were none.
double mean_chunk_paths(std::span<const WorkerTally> tallies);

}  // namespace eikon
