// SPDX-License-Identifier: Apache-2.0
#include "io/xxhash64.h"

#include <xxhash.h>

namespace eikon {

std::uint64_t xxhash64(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH64(bytes.data(), bytes.size(), seed);
}

}  // namespace eikon
