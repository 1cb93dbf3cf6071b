// SPDX-License-Identifier: Apache-2.0
// The fixed-point numbers of the film on the host: the oracle for what the film stage computes.
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "film/film.h"

namespace eikon {

/// A film takes samples that are finite and below 2^38 in magnitude.
[[nodiscard]] inline bool fits_film(float value) { return std::abs(value) < 0x1p38f; }  // false for NaN

/// floor(value * 2^64). It is exact for |value| >= 2^-41; a smaller value is rounded towards minus
/// infinity, by less than 2^-64.
/// throws InternalError unless fits_film(value)
[[nodiscard]] inline int128 to_fixed(float value) {
  if (!fits_film(value)) throw InternalError(fmt::format("the film cannot hold the sample {}", value));
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t exponent = (bits >> 23) & 0xffu;
  const std::uint32_t mantissa = exponent == 0 ? bits & 0x7fffffu : (bits & 0x7fffffu) | 0x800000u;
  // |value| = mantissa * 2^(max(exponent, 1) - 150)
  const int shift = static_cast<int>(exponent == 0 ? 1 : exponent) - 150 + 64;
  const int128 signed_mantissa = bits >> 31 ? -static_cast<int128>(mantissa) : static_cast<int128>(mantissa);
  return shift >= 0 ? signed_mantissa << shift
                    : signed_mantissa >> -shift;  // arithmetic shift: floor; at most 85 places
}

/// A sum in its packed form (kernels/shared/packed_sums.h).
struct PackedSum {
  std::int64_t number = 0;
  std::uint32_t shift = 0;
  [[nodiscard]] int128 sum() const { return static_cast<int128>(number) << shift; }
};

/// Packs a sum; nothing if it does not fit.
[[nodiscard]] inline std::optional<PackedSum> packed_sum(int128 sum) {
  PackedSum packed;
  while (sum != 0 && sum % 2 == 0) sum /= 2, ++packed.shift;
  packed.number = static_cast<std::int64_t>(sum);
  if (packed.number != sum) return std::nullopt;
  return packed;
}

}  // namespace eikon
