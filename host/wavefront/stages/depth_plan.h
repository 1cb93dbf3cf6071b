// SPDX-License-Identifier: Apache-2.0
// Decides how many depths of a unit are launched before the host looks at how many paths are left.
// Plain numbers, no device.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/queue_counts.h"

namespace eikon {

/// While many paths are left, a stage is launched with one work-item for each, so the host reads
/// their number after each depth. When at most kFew paths are left, a launch takes as long with
/// work-items that have no path, and waiting for the host would take longer. So the depths that are
/// left are launched all at once: as many as units before had from such a number of paths on.
class DepthPlan {
 public:
  /// So few work-items cost next to nothing, whether or not they have a path.
  static constexpr std::uint64_t kFew = 1U << 16;
  static constexpr std::uint32_t kMaxAtOnce = EK_COUNT_DEPTHS / 2;

  /// The depths to launch next.
  /// paths  of the last depth whose number of paths is known
  /// since  depths from that one on that are launched already
  [[nodiscard]] std::uint32_t depths(std::uint64_t paths, std::uint32_t since) const {
    if (paths > kFew) return 1;
    const std::uint32_t from = depths_from_[place(paths)];
    return std::clamp(from > since ? from - since : 1U, 1U, kMaxAtOnce);
  }
  /// Notes the paths of the next depth of a unit; 0 ends it.
  void add(std::uint64_t paths) {
    counts_.push_back(paths);
    if (paths > 0) return;
    for (std::size_t left = 1; left < counts_.size(); ++left)
      if (const std::uint64_t count = counts_[counts_.size() - 1 - left]; count <= kFew)
        depths_from_[place(count)] = std::uint32_t(left);
    counts_.clear();
  }
  /// Forgets a unit that did not end.
  void restart() { counts_.clear(); }

 private:
  static constexpr std::uint32_t kUnknown = 4;
  static constexpr std::size_t kPlaces = std::bit_width(kFew) + 1;
  [[nodiscard]] static std::size_t place(std::uint64_t paths) { return std::size_t(std::bit_width(paths)); }

  /// Depths that the last unit had from the first one on with less than 2^i paths, and no fewer
  /// than half of that.
  std::array<std::uint32_t, kPlaces> depths_from_ = [] {
    std::array<std::uint32_t, kPlaces> unknown{};
    unknown.fill(kUnknown);
    return unknown;
  }();
  std::vector<std::uint64_t> counts_;  // of the unit under way
};

}  // namespace eikon
