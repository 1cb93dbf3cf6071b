// SPDX-License-Identifier: Apache-2.0
#include "wavefront/timing/stage_shares.h"

#include <algorithm>

namespace eikon {
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
#define EK_PATH_STAGE(name) add(#name);
#include "shared/stages.def"
  return shares;
}

}  // namespace eikon
