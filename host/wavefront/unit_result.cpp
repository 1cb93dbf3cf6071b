// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "wavefront/wavefront.h"

namespace eikon {

UnitResult unit_result(const UnitSums& sums, const RayCounts& rays, const Diagnostics& diagnostics) {
  UnitResult result{.sums = sums,
                    .rays = rays,
                    .given_up = diagnostics.given_up,
                    .given_up_surfaces = diagnostics.given_up_surfaces,
                    .nonfinite = diagnostics.nonfinite,
                    .saturated = diagnostics.saturated,
                    .rejected = {}};
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(diagnostics.reported, EK_REPORT_COUNT); ++i) {
    const std::uint32_t xy = sums.pixels[diagnostics.report[2 * i]];
    result.rejected.push_back({xy & 0xffffU, xy >> 16, sums.sample_begin + diagnostics.report[2 * i + 1]});
  }
  return result;
}

}  // namespace eikon
