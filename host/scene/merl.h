// SPDX-License-Identifier: Apache-2.0
// Files of measured BRDFs as the MERL database has them [Matusik et al. 2003]: three int32, the
// numbers of cells of theta_h, theta_d and phi_d, then that many doubles for red, for green and for
// blue, little-endian, phi_d fastest; f is 1/1500, 1.15/1500 and 1.66/1500 times those. Below 0: no
// measurement.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "shared/measured.h"

namespace eikon {

inline constexpr std::uint64_t kMerlBytes = 12 + std::uint64_t{8} * 3 * EK_MEASURED_CELLS;

/// f of R, G, B of each cell, 1/sr, in the file's order. Entries without a measurement stay
/// negative.
/// throws InputError (without the name): wrong size, other dimensions, numbers that are not finite
///        or beyond 1e30
[[nodiscard]] std::vector<float> read_merl(std::span<const std::byte> file);

/// Writes such values so that read_merl gives them back, bit for bit; negative ones become -1. The
/// file appears complete or not at all.
/// throws InputError as AtomicFile
void write_merl(const std::filesystem::path& path, std::span<const float> rgb);

}  // namespace eikon
