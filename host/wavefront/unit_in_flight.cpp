// SPDX-License-Identifier: Apache-2.0
#include "wavefront/unit_in_flight.h"

#include <algorithm>

namespace eikon {
namespace {

UnitResult unit_result(const UnitSums& sums, const RayCounts& rays, const Diagnostics& diagnostics) {
  UnitResult result{.sums = sums,
                    .rays = rays,
                    .light_rays = {},
                    .search_failures = diagnostics.given_up,
                    .search_failure_surfaces = diagnostics.given_up_surfaces,
                    .nonfinite = diagnostics.nonfinite,
                    .saturated = diagnostics.saturated,
                    .rejected = {}};
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(diagnostics.reported, EK_REPORT_COUNT); ++i) {
    const std::uint32_t xy = sums.pixels[diagnostics.report[2 * i]];
    result.rejected.push_back({xy & 0xffffU, xy >> 16, sums.sample_begin + diagnostics.report[2 * i + 1]});
  }
  return result;
}

}  // namespace

void UnitInFlight::resize(Device& device, const FilmShape& shape, bool packs) {
  sums.resize(packs ? 0 : shape.sum_words(frame.pixel_count));
  packed.resize(device, packs ? shape.packed_words(frame.pixel_count) : 0);
  diagnostics_words.resize(device, sizeof(Diagnostics) / 4);
  rejected.resize(shape.rejected_words(frame.pixel_count));
  matte_numbers.resize(std::size_t{shape.mattes} * frame.path_count);
}

UnitResult UnitInFlight::result(const Mattes& mattes) const {
  const UnitSums all = {.pixels = pixels.words(),
                        .pixel_stride = frame.pixel_stride,
                        .sample_begin = unit.sample_begin,
                        .sample_end = unit.sample_end,
                        .limbs = sums,
                        .rejected = rejected,
                        .packed = packed.words(),
                        .matte_numbers = matte_numbers,
                        .matte_ids = mattes.ids,
                        .splats = lights.splats,
                        .light_paths = lights.count};
  UnitResult result = unit_result(all, rays, diagnostics);
  result.rays += lights.rays;
  result.rays += photon_rays;
  result.light_rays = lights.rays;
  result.light_rays += photon_rays;
  result.nonfinite += lights.nonfinite;
  result.saturated += lights.saturated;
  return result;
}

}  // namespace eikon
