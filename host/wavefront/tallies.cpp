// SPDX-License-Identifier: Apache-2.0
#include "wavefront/tallies.h"

#include <algorithm>

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

namespace {

std::uint64_t ticks(const std::uint32_t* words) { return words[0] | std::uint64_t{words[1]} << 32; }

}  // namespace

std::map<std::string, double> stage_shares(std::span<const WorkerTally> tallies) {
  if (tallies.empty()) return {};
  std::uint64_t begin = ~std::uint64_t{0}, end = 0;
  for (const WorkerTally& tally : tallies) {
    begin = std::min(begin, ticks(tally.begin));
    end = std::max(end, ticks(tally.end));
  }
  if (end <= begin) return {};
  const double all = double(end - begin) * double(tallies.size());
  std::map<std::string, double> shares;
  std::size_t stage = 0;
  const auto add = [&](const char* name) {
    std::uint64_t sum = 0;
    for (const WorkerTally& tally : tallies) sum += ticks(tally.ticks + 2 * stage);
    if (sum > 0) shares[name] = double(sum) / all;
    ++stage;
  };
#define EK_PATH_STAGE(name) +1
  static_assert(0
#include "shared/stages.def"
                    == EK_PATH_STAGES,
                "WorkerTally.ticks has another number of stages than stages.def");
#define EK_PATH_STAGE(name) add(#name);
#include "shared/stages.def"
  return shares;
}

}  // namespace eikon
