// SPDX-License-Identifier: Apache-2.0
// The size of a unit's packed sums.
#pragma once
#include <cstddef>

#include "shared/packed_sums.h"

namespace eikon {

/// Words of them: see kernels/shared/packed_sums.h.
/// sums    of a pixel: one for each replicate and channel
/// stride  pixels of a plane
[[nodiscard]] constexpr std::size_t packed_words(std::size_t sums, std::size_t stride) {
  return EK_PACKED_HEAD + (2 * sums + (sums + 3) / 4) * stride;
}

}  // namespace eikon
