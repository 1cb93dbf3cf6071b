// SPDX-License-Identifier: Apache-2.0
#include "wavefront/replay.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <tuple>

#include "shared/splat.h"

namespace eikon {

std::vector<ReplayedSample::Splat> replayed_splats(std::span<const std::uint32_t> words, std::uint64_t paths) {
  std::vector<ReplayedSample::Splat> splats;
  for (; words.size() >= SPLAT_WORDS; words = words.subspan(SPLAT_WORDS)) {
    ReplayedSample::Splat& splat = splats.emplace_back();
    splat.scatterings = EK_SPLAT_SCATTERINGS(words[SPLAT_info]);
    for (std::size_t c = 0; c < 3; ++c)
      splat.radiance[int(c)] = std::bit_cast<float>(words[SPLAT_r + c]) / float(paths);
  }
  // Chance says in which order they were written.
  std::ranges::sort(splats, std::greater{}, [](const ReplayedSample::Splat& s) {
    return std::tuple(s.radiance.x, s.radiance.y, s.radiance.z, s.scatterings);
  });
  return splats;
}

}  // namespace eikon
