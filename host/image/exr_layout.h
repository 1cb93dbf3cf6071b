// SPDX-License-Identifier: Apache-2.0
// Names that the EXR writer and reader share.
#pragma once
#include <cstdint>
#include <string>

#include <fmt/format.h>

namespace eikon::exr {

inline constexpr const char* kImagePart = "image";
inline constexpr const char* kSumsPart = "sums";
inline constexpr const char* kPrefix = "eikon.";
inline constexpr const char* kReplicates = "eikon.replicates";  // int attribute of the sums part
inline constexpr const char* kChannels = "eikon.channels";  // string attribute of the sums part: names joined by commas
inline constexpr int kRowsPerBlock = 16;                    // of ZIP compression; rows converted at a time
inline constexpr std::uint32_t kSumLimbs = 4, kCountLimbs = 2;  // 32-bit words, low first

/// Channels of the sums part.
inline std::string sum_name(std::uint32_t replicate, const std::string& channel, std::uint32_t limb) {
  return fmt::format("r{}.{}.{}", replicate, channel, limb);
}
inline std::string count_name(std::uint32_t replicate, std::uint32_t limb) {
  return fmt::format("r{}.count.{}", replicate, limb);
}

}  // namespace eikon::exr
