// SPDX-License-Identifier: Apache-2.0
// Reads what kernels count: the paths in the queues after a depth, how full lanes and queues are at
// each bounce, and the stages' shares of the time of a launch.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "shared/records.h"

namespace eikon {

/// The words of buffer `counts` (kernels/stages/wavefront.h) for each chunk: paths at even depths,
/// paths at odd depths, shadow rays, and one that is not read back.
inline constexpr std::size_t kQueueWords = 4;

/// Numbers of paths and rays that the stages of a depth have put into the queues, of one chunk or
/// of several.
struct QueueCounts {
  std::uint64_t next_paths = 0;  // that go on to the next depth
  std::uint64_t shadow_rays = 0;
};
/// counts  kQueueWords words of each chunk
[[nodiscard]] inline QueueCounts queue_counts(std::span<const std::uint32_t> counts, std::size_t chunk,
                                              std::uint32_t depth) {
  const auto words = counts.subspan(chunk * kQueueWords, kQueueWords);
  return {.next_paths = words[(depth + 1) & 1], .shadow_rays = words[2]};
}

/// The sums over all chunks.
[[nodiscard]] inline QueueCounts total_counts(std::span<const std::uint32_t> counts, std::uint32_t depth) {
  QueueCounts total;
  for (std::size_t chunk = 0; chunk < counts.size() / kQueueWords; ++chunk) {
    const QueueCounts of_chunk = queue_counts(counts, chunk, depth);
    total.next_paths += of_chunk.next_paths;
    total.shadow_rays += of_chunk.shadow_rays;
  }
  return total;
}

/// Rays that were traced at a depth, and the lanes and slots that were held for them.
struct Bounce {
  std::uint64_t paths = 0;        // that reached it: camera and scattered rays
  std::uint64_t shadow_rays = 0;  // cast there
  std::uint64_t lanes = 0;        // that ran, with or without a path: whole vectors of a chunk, or whole work-groups
  std::uint64_t slots = 0;        // of the chunks that still had paths, or of the whole unit where there are no chunks
  Bounce& operator+=(const Bounce& more) {
    paths += more.paths, shadow_rays += more.shadow_rays, lanes += more.lanes, slots += more.slots;
    return *this;
  }
};

/// Indexed by depth - 1; the last entry sums up all deeper bounces.
using Bounces = std::array<Bounce, EK_TALLY_DEPTHS>;

inline Bounce& bounce_at(Bounces& bounces, std::uint32_t depth) {
  return bounces[depth < EK_TALLY_DEPTHS ? depth - 1 : EK_TALLY_DEPTHS - 1];
}

inline void add_bounces(Bounces& bounces, const Bounces& more) {
  for (std::size_t i = 0; i < bounces.size(); ++i) bounces[i] += more[i];
}

/// Adds the counts of the work-items of a launch of kernel `paths`.
void add_bounces(Bounces& bounces, std::span<const WorkerTally> tallies, std::uint32_t width, std::uint32_t chunk);

/// Mean number of live paths in a chunk, over all bounces of all chunks; 0 if there were none.
double mean_chunk_paths(std::span<const WorkerTally> tallies);

/// The share of each stage in a launch of kernel `paths`: the stage's ticks over the ticks of all
/// work-items from the first begin to the last end. So the shares, and the time that work-items
/// spent waiting and taking chunks, add up to 1. Empty if the processor has no counter.
std::map<std::string, double> stage_shares(std::span<const WorkerTally> tallies);

}  // namespace eikon
