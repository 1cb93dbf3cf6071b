// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "io/xxhash64.h"

namespace eikon {

/// Identifies the bytes that a scene was read from. Each file's hash seeds the next one's, so the
/// order of the files counts.
struct Digest {
  std::uint64_t hash = 0, bytes = 0;

  void add(std::span<const std::byte> file) {
    hash = xxhash64(file, hash);
    bytes += file.size();
  }
};

}  // namespace eikon
