// SPDX-License-Identifier: Apache-2.0
// How full the lanes and the queues are at each bounce.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "shared/records.h"

namespace eikon {

/// What was traced at a depth, and the places that were held for it.
struct Bounce {
  std::uint64_t paths = 0;        // that reached it: camera and scattered rays
  std::uint64_t shadow_rays = 0;  // cast there
  std::uint64_t lanes = 0;  // that ran, with a path or without: whole vectors of a chunk, whole work-groups of a queue
  std::uint64_t slots = 0;  // of the chunks that still had paths, or of the pool that the queue is of
};

/// By depth - 1; what is deeper is with the last.
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

/// Adds what the work-items of a launch of kernel `paths` counted.
void add_bounces(Bounces& bounces, std::span<const WorkerTally> tallies, std::uint32_t width, std::uint32_t chunk);

/// Paths of a chunk at work, on the average over the bounces that its work-items took it through; 0 where there were none.
double mean_chunk_paths(std::span<const WorkerTally> tallies);

}  // namespace eikon
