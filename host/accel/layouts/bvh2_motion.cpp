// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <utility>
#include <vector>

#include "accel/layouts/layouts.h"
#include "accel/layouts/pose_boxes.h"

namespace eikon {
namespace {

constexpr std::size_t kPosedNodeWords = 16, kLinkWord = 12, kPosesWord = 14;

/// Gives the nodes of a bvh2 boxes at each pose, from the leaves up.
class Bvh2PoseFitter {
 public:
  Bvh2PoseFitter(Accel& accel, const TrianglePoses& poses) : accel_(accel), bounds_(poses, accel.leaves) {}

  void fit() {
    const std::size_t count = accel_.nodes.size() / kPosedNodeWords;
    std::vector<PoseBoxes> of_node(count);
    for (std::size_t n = count; n-- > 0;) {  // children come after their parents
      const PoseBoxes sides[2] = {side(of_node, n, 0), side(of_node, n, 1)};
      of_node[n] = sides[0];
      for (std::size_t pose = 0; pose < of_node[n].size(); ++pose) of_node[n][pose].add(sides[1][pose]);
      if (!PoseBounds::moves(sides[0]) && !PoseBounds::moves(sides[1])) continue;
      accel_.nodes[kPosedNodeWords * n + kPosesWord] = std::uint32_t(accel_.nodes.size() / kPosedNodeWords);
      for (std::size_t pose = 0; pose < bounds_.count(); ++pose) {
        accel_.nodes.resize(accel_.nodes.size() + kPosedNodeWords, 0);
        for (std::size_t s = 0; s < 2; ++s) write(accel_.nodes.size() - kPosedNodeWords + 6 * s, sides[s], pose);
      }
    }
  }

 private:
  /// The boxes of a child; those of its own children are not needed any more.
  PoseBoxes side(std::vector<PoseBoxes>& of_node, std::size_t node, std::size_t which) const {
    const std::uint32_t word = accel_.nodes[kPosedNodeWords * node + kLinkWord + which];
    if ((word & kLeafBit) == 0) return std::move(of_node[word]);
    PoseBoxes boxes(bounds_.count());
    const bool is_missing = accel_.nodes[kPosedNodeWords * node + 6 * which] == 0x7f800000U;
    const std::uint32_t first = word & ((1U << kCountShift) - 1), count = ((word >> kCountShift) & 7U) + 1;
    for (std::uint32_t i = first; i < first + count && !is_missing; ++i) bounds_.add(accel_.leaves[i], boxes);
    return boxes;
  }

  void write(std::size_t to, const PoseBoxes& boxes, std::size_t pose) {
    const std::array<float, 6> planes = bounds_.planes(boxes, pose);
    for (std::size_t k = 0; k < 6; ++k) accel_.nodes[to + k] = std::bit_cast<std::uint32_t>(planes[k]);
  }

  Accel& accel_;
  PoseBounds bounds_;
};

}  // namespace

void fit_bvh2_to_poses(Accel& accel, const TrianglePoses& poses) { Bvh2PoseFitter(accel, poses).fit(); }

}  // namespace eikon
