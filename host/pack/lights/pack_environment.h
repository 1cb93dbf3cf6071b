// SPDX-License-Identifier: Apache-2.0
// Lays the environment's map out for lookup and sampling; kernels/lights/environment_map.h explains
// both.
#pragma once
#include "pack/pack.h"

namespace eikon {

/// Fills packed.environment_texels (w: density per sr given that the map is chosen) and
/// packed.environment_alias_table.
/// returns  the integral over all directions of its radiance, mean of R, G and B: W / m^2; 0 where
///          it is black
/// throws   InputError for more than 2^28 texels, or a scale that takes its radiance beyond 1e30
double pack_environment_map(const Environment& environment, PackedScene& packed);

/// Solid angle of each texel of row `row` of a map, sr.
[[nodiscard]] double texel_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height);

}  // namespace eikon
