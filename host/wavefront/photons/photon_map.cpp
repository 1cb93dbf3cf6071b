// SPDX-License-Identifier: Apache-2.0
#include "wavefront/photons/photon_map.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

#include "guide/guide_table.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMinPaths = 1U << 6;  // of a map
// All maps of a generation have at most so many together, so that they take little memory and are
// made long before the watchdog's time is over.
constexpr std::uint64_t kMaxPaths = 1U << 18;
constexpr std::uint64_t kMinRatio = 16;  // camera paths for each light path of the maps, at most
constexpr double kAlpha = 2.0 / 3;
// The memory of maps is estimated by these. Shipped scenes have at most 1.6 photons for each light
// path. Cells are as wide as the ball of a photon, which therefore reaches two of them along each
// axis.
constexpr std::uint64_t kPhotonsPerPath = 2, kPlacesPerPhoton = 8, kBucketsPerPath = 1;
// The radius within which the table has the photons is larger than the one in which they are
// gathered, for what kernels may round up.
constexpr float kReach = 1.0001F;

using Photon = std::array<std::uint32_t, PHOTON_WORDS>;

bool comes_before(const Photon& a, const Photon& b) {
  const auto key = [](const Photon& p) {
    return std::make_tuple(EK_PHOTON_REPLICATE(p[PHOTON_info]), p[PHOTON_order], p[PHOTON_info]);
  };
  return key(a) != key(b) ? key(a) < key(b) : a < b;
}

/// As cell_coordinate of kernels/guide/cell.h.
std::uint32_t cell_coordinate(float x) {
  return std::uint32_t(int(std::floor(std::clamp(x, -32768.0F, 32767.0F))) + 32768);
}

/// The buckets in which a photon stands, each once.
/// found  receives them
void buckets_of(const Photon& photon, float reach, float scale, std::uint32_t mask, std::vector<std::uint32_t>& found) {
  std::array<std::uint32_t, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = std::bit_cast<float>(photon[PHOTON_x + axis]);
    const float low = at - reach, high = at + reach;
    first[axis] = cell_coordinate(low * scale);
    last[axis] = cell_coordinate(high * scale);
  }
  found.clear();
  const std::uint32_t replicate = EK_PHOTON_REPLICATE(photon[PHOTON_info]);
  for (std::uint32_t z = first[2]; z <= last[2]; ++z)
    for (std::uint32_t y = first[1]; y <= last[1]; ++y)
      for (std::uint32_t x = first[0]; x <= last[0]; ++x)
        found.push_back(cell_hash(x | y << 16, z | replicate << 16) & mask);
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());  // not of ranges, which clang 14 does not compile
}

}  // namespace

PhotonPlan photon_plan(const Settings& settings) {
  if (!settings.merges_caustics) return {};
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  const std::uint64_t replicates = std::uint64_t{1} << settings.replicate_bits;
  const std::uint64_t of_sample = std::max({settings.light_path_count, pixels / kMinRatio, std::uint64_t{1}});
  const std::uint64_t most = kMaxPaths / replicates;
  const std::uint64_t paths = std::bit_floor(std::clamp(pixels, std::min(kMinPaths, most), most));
  return {paths, replicates * std::bit_ceil((paths + of_sample - 1) / of_sample)};
}

std::uint64_t photon_map_bytes(const Settings& settings) {
  const std::uint64_t paths = photon_plan(settings).paths << settings.replicate_bits;
  return 4 * paths * (kPhotonsPerPath * (PHOTON_WORDS + kPlacesPerPhoton) + kBucketsPerPath);
}

double photon_radius2(double first, std::uint64_t generation) {
  double radius2 = first;
  for (std::uint64_t i = 1; i <= generation; ++i) radius2 *= (double(i) + kAlpha) / (double(i) + 1);
  return radius2;
}

PhotonMap make_photon_map(std::vector<std::uint32_t> photons, float radius2, float cell_scale) {
  std::vector<Photon> sorted(photons.size() / PHOTON_WORDS);
  if (!sorted.empty()) std::memcpy(sorted.data(), photons.data(), sorted.size() * sizeof(Photon));
  tbb::parallel_sort(sorted.begin(), sorted.end(), comes_before);
  if (!sorted.empty()) std::memcpy(photons.data(), sorted.data(), sorted.size() * sizeof(Photon));

  PhotonMap map{std::move(photons), {}, {}};
  const auto mask = std::uint32_t(std::bit_ceil(std::max<std::size_t>(sorted.size(), 1)) - 1);
  const float reach = std::sqrt(radius2) * kReach;
  map.buckets.assign(std::size_t{mask} + 2, 0);
  std::vector<std::uint32_t> of_photon;
  for (const Photon& photon : sorted) {
    buckets_of(photon, reach, cell_scale, mask, of_photon);
    for (const std::uint32_t bucket : of_photon) ++map.buckets[bucket + 1];
  }
  for (std::size_t i = 1; i < map.buckets.size(); ++i) map.buckets[i] += map.buckets[i - 1];
  map.places.resize(map.buckets.back());
  std::vector<std::uint32_t> next(map.buckets.begin(), map.buckets.end() - 1);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    buckets_of(sorted[i], reach, cell_scale, mask, of_photon);
    for (const std::uint32_t bucket : of_photon) map.places[next[bucket]++] = std::uint32_t(i);
  }
  return map;
}

}  // namespace eikon
