// SPDX-License-Identifier: Apache-2.0
#include "wavefront/bounces.h"

namespace eikon {

void add_bounces(Bounces& bounces, std::span<const WorkerTally> tallies, std::uint32_t width, std::uint32_t chunk) {
  for (const WorkerTally& tally : tallies)
    for (std::size_t i = 0; i < EK_TALLY_DEPTHS; ++i) {
      bounces[i].paths += tally.depth_paths[i];
      bounces[i].shadow_rays += tally.depth_shadow[i];
      bounces[i].lanes += std::uint64_t{tally.depth_vectors[i]} * width;
      bounces[i].slots += std::uint64_t{tally.depth_chunks[i]} * chunk;
    }
}

double mean_chunk_paths(std::span<const WorkerTally> tallies) {
  Bounces all{};
  add_bounces(all, tallies, 1, 1);
  std::uint64_t paths = 0, chunks = 0;
  for (const Bounce& bounce : all) paths += bounce.paths, chunks += bounce.slots;
  return chunks > 0 ? double(paths) / double(chunks) : 0;
}

}  // namespace eikon
