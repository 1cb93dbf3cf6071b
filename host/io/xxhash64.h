// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace eikon {

/// XXH64 of `bytes`, the same on any machine. It is no protection against forgery.
[[nodiscard]] std::uint64_t xxhash64(std::span<const std::byte> bytes, std::uint64_t seed);

}  // namespace eikon
