// SPDX-License-Identifier: Apache-2.0
// Splats: what light paths bring to pixels, in a list of each unit (kernels/film/splat.h). A unit
// has the light paths of its pixels, and these reach any pixel of the film's window. So splats have
// channels of their own, "splats.R" beside "R", and are divided by the number of light paths that
// were traced for the window. Each channel that holds radiance has one for splats, and its numbers
// have the unit of kSplatShift.
#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/error.h"
#include "film/film.h"
#include "film/layers.h"
#include "shared/splat.h"

namespace eikon {
namespace {

/// The channels to which a splat is added, for each kind of radiance that the film keeps: indices
/// of the first of three.
struct SplatChannels {
  std::uint32_t rgb = 0;                                      // all light
  std::vector<std::pair<std::uint64_t, std::uint32_t>> bins;  // most scatterings of a bin, channel; in rising order
  std::vector<std::uint32_t> groups;                          // of each light group

  explicit SplatChannels(const FilmLayout& layout) {
    for (std::uint32_t c = 0; c < layout.channels.size(); ++c) {
      std::string_view name = layout.channels[c];
      if (!name.starts_with(kSplats) || !name.ends_with('R')) continue;
      name.remove_prefix(kSplats.size());
      if (name == "R")
        rgb = c;
      else if (const auto bound = bound_of(name))
        bins.emplace_back(*bound, c);
      else
        groups.push_back(c);
    }
  }
};

/// floor(x 2^(64 - kSplatShift)), of a finite x
int128 fixed_from_float(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t exponent = bits >> 23 & 0xffU, fraction = bits & 0x7fffffU;
  const std::int64_t mantissa = exponent == 0 ? fraction : fraction | 0x800000U;
  const int128 whole = (bits >> 31) != 0 ? -mantissa : mantissa;
  const int shift = static_cast<int>(std::max(exponent, 1U)) - 150 + 64 - kSplatShift;
  if (shift >= 0) return static_cast<int128>(static_cast<unsigned __int128>(whole) << shift);
  return whole >> std::min(-shift, 32);  // rounds down
}

}  // namespace

void Film::add_splats(const UnitSums& unit) {
  const SplatChannels to(layout_);
  const std::size_t channels = layout_.channels.size(), replicates = layout_.replicates;
  if (unit.splats.size() % SPLAT_WORDS != 0 || to.rgb == 0) throw InternalError("splats do not fit the film");
  const auto add = [&](std::size_t cell, std::uint32_t first, const std::uint32_t* splat) {
    for (std::uint32_t c = 0; c < 3; ++c)
      add_to_sum(cell * channels + first + c, fixed_from_float(std::bit_cast<float>(splat[SPLAT_r + c])));
  };
  const auto cell_of = [&](const std::uint32_t* splat) {
    return pixel_index(splat[SPLAT_pixel] & 0xffffU, splat[SPLAT_pixel] >> 16) * replicates +
           EK_SPLAT_REPLICATE(splat[SPLAT_info]);
  };
  // Pixels come in any order, so their sums are seldom in a cache.
  constexpr std::size_t kAhead = 16 * SPLAT_WORDS;
  for (std::size_t at = 0; at < unit.splats.size(); at += SPLAT_WORDS) {
    if (at + kAhead < unit.splats.size())
      __builtin_prefetch(sums_.data() + cell_of(&unit.splats[at + kAhead]) * channels + to.rgb, 1);
    const std::uint32_t* const splat = &unit.splats[at];
    const std::uint32_t info = splat[SPLAT_info], replicate = EK_SPLAT_REPLICATE(info);
    const std::uint32_t scatterings = EK_SPLAT_SCATTERINGS(info), group = EK_SPLAT_GROUP(info);
    if (replicate >= replicates || (!to.groups.empty() && group >= to.groups.size()))
      throw InternalError("a splat of a replicate or light group that the film does not have");
    const std::size_t cell = cell_of(splat);
    add(cell, to.rgb, splat);
    for (const auto& [most, channel] : to.bins)
      if (scatterings <= most) {
        add(cell, channel, splat);
        break;
      }
    if (!to.groups.empty()) add(cell, to.groups[group], splat);
  }
  LightPathCount count{layout_.crop, {}};
  for (std::uint32_t r = 0; r < replicates; ++r)
    count.paths.push_back(unit.light_paths * samples_of_replicate(unit.sample_begin, unit.sample_end, r, layout_.replicates));
  add_light_paths(count);
}

}  // namespace eikon
