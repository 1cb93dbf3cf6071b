// SPDX-License-Identifier: Apache-2.0
// Files of --pilot that were changed on purpose.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "io/xxhash64.h"

namespace eikon::test {

/// The bytes of a file of --pilot with the checksum of what they are now.
inline std::string signed_again(std::string bytes) {
  bytes.resize(bytes.size() - sizeof(std::uint64_t));
  const std::uint64_t hash = xxhash64(std::as_bytes(std::span(bytes.data(), bytes.size())), 0);
  return bytes.append(reinterpret_cast<const char*>(&hash), sizeof hash);
}

}  // namespace eikon::test
