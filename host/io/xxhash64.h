// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace eikon {

/// XXH64 of `bytes`, the same on any machine. It is no protection against forgery.
[[nodiscard]] std::uint64_t xxhash64(std::span<const std::byte> bytes, std::uint64_t seed);

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
