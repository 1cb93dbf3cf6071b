// SPDX-License-Identifier: Apache-2.0
// Photons: light that light paths leave on surfaces, for camera paths that see these through glass
// or in mirrors (kernels/stages/shade/merge.h).
#pragma once
#include <cstdint>
#include <vector>

#include "pack/settings.h"
#include "shared/photon.h"

namespace eikon {

/// The photon maps of an image. Its samples are divided into generations, which have as many
/// samples each whatever is rendered of the image. Each replicate of a generation has a map, from
/// light paths of its own.
struct PhotonPlan {
  std::uint64_t paths = 0;    // light paths of a map, a power of two; 0: there are no maps
  std::uint64_t samples = 1;  // of a generation, a power of two
};
[[nodiscard]] PhotonPlan photon_plan(const Settings& settings);

/// Bytes of device memory that the maps of a generation are expected to take; 0 if there are none.
[[nodiscard]] std::uint64_t photon_map_bytes(const Settings& settings);

/// The square of the radius in which photons are gathered falls as published for progressive photon
/// mapping [Knaus and Zwicker 2011, "Progressive Photon Mapping: A Probabilistic Approach",
/// equation 19, with alpha = 2/3].
/// first  that of generation 0
[[nodiscard]] double photon_radius2(double first, std::uint64_t generation);

/// The maps of one generation, in one hash table (kernels/lights/photon_map.h).
struct PhotonMap {
  std::vector<std::uint32_t> photons;  // PHOTON_WORDS each
  std::vector<std::uint32_t> places, buckets;
};

/// Sorts photons, so that their order does not depend on that in which a device found them, and
/// makes the table.
/// radius2     square of the radius, as kernels have it
/// cell_scale  1 / side of a cell
[[nodiscard]] PhotonMap make_photon_map(std::vector<std::uint32_t> photons, float radius2, float cell_scale);

}  // namespace eikon
