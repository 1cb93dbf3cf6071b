// SPDX-License-Identifier: Apache-2.0
// The encoding of sRGB.
#pragma once
#include <cmath>

namespace eikon {

/// The linear value of an encoded one [IEC 61966-2-1]; both are 0 for black and 1 for white.
[[nodiscard]] inline double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace eikon
