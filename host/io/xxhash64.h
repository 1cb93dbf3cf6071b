// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace eikon {

/// XXH64 of `bytes`, as the reference implementation gives it on any machine. Not for security.
/// source  [Collet 2012, xxHash specification 0.1.1, "XXH64 algorithm description"]
[[nodiscard]] std::uint64_t xxhash64(std::span<const std::byte> bytes, std::uint64_t seed);

}  // namespace eikon
