// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "accel/layouts/layouts.h"

namespace eikon {
namespace {

constexpr std::size_t kPosedNodeWords = 16, kLinkWord = 12, kPosesWord = 14;

using PoseBoxes = std::vector<Box>;  // one per pose

/// Gives the nodes of a tree boxes at each pose, from the leaves up.
class PoseFitter {
 public:
  PoseFitter(Accel& accel, const TrianglePoses& poses) : accel_(accel), poses_(poses) {
    for (std::size_t i = 0; i < accel.leaves.size(); ++i)
      for (std::size_t pose = 0; pose < poses.count; ++pose)
        for (int k = 0; k < 9; ++k) farthest_ = std::max(farthest_, std::abs(corners(accel.leaves[i], pose)[k]));
  }

  void fit() {
    const std::size_t count = accel_.nodes.size() / kPosedNodeWords;
    std::vector<PoseBoxes> of_node(count);
    for (std::size_t n = count; n-- > 0;) {  // children come after their parents
      const PoseBoxes sides[2] = {side(of_node, n, 0), side(of_node, n, 1)};
      of_node[n] = sides[0];
      for (std::size_t pose = 0; pose < of_node[n].size(); ++pose) of_node[n][pose].add(sides[1][pose]);
      if (!moves(sides[0]) && !moves(sides[1])) continue;
      accel_.nodes[kPosedNodeWords * n + kPosesWord] = std::uint32_t(accel_.nodes.size() / kPosedNodeWords);
      for (std::size_t pose = 0; pose < poses_.count; ++pose) {
        accel_.nodes.resize(accel_.nodes.size() + kPosedNodeWords, 0);
        for (std::size_t s = 0; s < 2; ++s) write(accel_.nodes.size() - kPosedNodeWords + 6 * s, sides[s], pose);
      }
    }
  }

 private:
  [[nodiscard]] const float* corners(std::uint32_t triangle, std::size_t pose) const {
    return poses_.corners + poses_.stride * (poses_.motion[triangle] - 1 + pose);
  }

  /// The boxes of a child; those of its own children are not needed any more.
  PoseBoxes side(std::vector<PoseBoxes>& of_node, std::size_t node, std::size_t which) const {
    const std::uint32_t word = accel_.nodes[kPosedNodeWords * node + kLinkWord + which];
    if ((word & kLeafBit) == 0) return std::move(of_node[word]);
    PoseBoxes boxes(poses_.count);
    const bool is_missing = accel_.nodes[kPosedNodeWords * node + 6 * which] == 0x7f800000U;
    const std::uint32_t first = word & ((1U << kCountShift) - 1), count = ((word >> kCountShift) & 7U) + 1;
    for (std::uint32_t i = first; i < first + count && !is_missing; ++i)
      for (std::size_t pose = 0; pose < poses_.count; ++pose)
        boxes[pose].add(triangle_box(corners(accel_.leaves[i], pose)));
    return boxes;
  }

  static bool moves(const PoseBoxes& boxes) {
    const auto differs = [&](const Box& box) {
      for (int axis = 0; axis < 3; ++axis)
        if (box.lo[axis] != boxes[0].lo[axis] || box.hi[axis] != boxes[0].hi[axis]) return true;
      return false;
    };
    return std::ranges::any_of(boxes, differs);
  }

  /// With u = 2^-24 and all coordinates within M, a coordinate of a corner or of a plane is off by at most 5 u M where
  /// kernels interpolate it: 2 u M for the difference, as much for its product with the share, and u M for the sum. So a
  /// plane that lies 16 u M further out stays outside of every corner.
  void write(std::size_t to, const PoseBoxes& boxes, std::size_t pose) {
    const double margin = moves(boxes) ? 0x1p-20 * double{farthest_} : 0;
    constexpr float kMost = std::numeric_limits<float>::max();
    for (int axis = 0; axis < 3; ++axis) {
      const float lo = boxes[pose].lo[axis], hi = boxes[pose].hi[axis];
      const bool is_missing = lo > hi;  // infinite planes have no difference
      accel_.nodes[to + std::size_t(axis)] = std::bit_cast<std::uint32_t>(is_missing ? kMost : outwards(lo, -margin));
      accel_.nodes[to + std::size_t(axis) + 3] =
          std::bit_cast<std::uint32_t>(is_missing ? -kMost : outwards(hi, margin));
    }
  }
  static float outwards(float x, double way) {
    if (way == 0) return x;
    const auto moved = float(double{x} + way);
    return std::nextafter(moved,
                          way < 0 ? -std::numeric_limits<float>::infinity() : std::numeric_limits<float>::infinity());
  }

  Accel& accel_;
  const TrianglePoses& poses_;
  float farthest_ = 0;
};

}  // namespace

void fit_bvh2_to_poses(Accel& accel, const TrianglePoses& poses) { PoseFitter(accel, poses).fit(); }

}  // namespace eikon
