// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <vector>

#include "accel/layouts/layouts.h"
#include "accel/layouts/pose_boxes.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kMovingNodeWords = 14;  // times the width
constexpr std::size_t kMovingBlockWords = 160;

/// Makes of each node and each leaf of a wide tree a row of records, one for each step between
/// poses (kernels/traverse/wide/wide.h).
class WidePoseFitter {
 public:
  WidePoseFitter(const Accel& accel, std::size_t width, const TrianglePoses& poses)
      : accel_(accel),
        width_(width),
        node_count_(accel.nodes.size() / (8 * width)),
        leaf_count_(accel.leaves.size() / kBlockWords),
        steps_(poses.count - 1),
        bounds_(poses, triangles_of(accel)) {
    of_node_.resize(node_count_, PoseBoxes(poses.count));
    for (std::size_t n = node_count_; n-- > 0;)  // children come after their parents
      for (std::size_t k = 0; k < width_; ++k) {
        const PoseBoxes boxes = child(n, k);
        for (std::size_t pose = 0; pose < poses.count; ++pose) of_node_[n][pose].add(boxes[pose]);
      }
  }

  void fit(Accel& to) const {
    if (std::max(node_count_, leaf_count_) * steps_ >= kLeafBit)
      throw InputError("a tree of triangles that move has too many poses; use fewer --motion-steps");
    DeviceVector<std::uint32_t> nodes(node_count_ * steps_ * kMovingNodeWords * width_);
    DeviceVector<std::uint32_t> leaves(leaf_count_ * steps_ * kMovingBlockWords);
    tbb::parallel_for(std::size_t{0}, node_count_, [&](std::size_t n) { write_node(n, nodes); });
    tbb::parallel_for(std::size_t{0}, leaf_count_, [&](std::size_t i) { write_leaf(i, leaves); });
    to.nodes = std::move(nodes);
    to.leaves = std::move(leaves);
  }

 private:
  static std::vector<std::uint32_t> triangles_of(const Accel& accel) {
    std::vector<std::uint32_t> all;
    for (std::size_t leaf = 0; leaf + kBlockWords <= accel.leaves.size(); leaf += kBlockWords)
      for (std::size_t i = 0; i < kBlock; ++i)
        if (accel.leaves[leaf + kBlockTriangles + i] != EK_NO_HIT)
          all.push_back(accel.leaves[leaf + kBlockTriangles + i]);
    return all;
  }

  [[nodiscard]] std::uint32_t word(std::size_t node, std::size_t at) const {
    return accel_.nodes[8 * width_ * node + at];
  }

  [[nodiscard]] PoseBoxes child(std::size_t node, std::size_t k) const {
    const std::uint32_t at = word(node, 6 * width_ + k);
    PoseBoxes boxes(bounds_.count());
    if (at == 0) return boxes;
    if ((at & kLeafBit) == 0) return of_node_[at];
    const std::size_t leaf = (at & ~kLeafBit) * std::size_t{kBlockWords};
    for (std::size_t i = 0; i < kBlock; ++i)
      if (accel_.leaves[leaf + kBlockTriangles + i] != EK_NO_HIT)
        bounds_.add(accel_.leaves[leaf + kBlockTriangles + i], boxes);
    return boxes;
  }

  void write_node(std::size_t node, DeviceVector<std::uint32_t>& nodes) const {
    for (std::size_t k = 0; k < width_; ++k) {
      const PoseBoxes boxes = child(node, k);
      const std::uint32_t at = word(node, 6 * width_ + k);
      for (std::size_t step = 0; step < steps_; ++step) {
        std::uint32_t* const to = nodes.data() + (node * steps_ + step) * kMovingNodeWords * width_;
        const std::array<float, 6> now = bounds_.planes(boxes, step), next = bounds_.planes(boxes, step + 1);
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (std::size_t side = 0; side < 2; ++side) {
            const std::size_t plane = 3 * side + axis, row = (2 * axis + side) * width_ + k;
            to[row] = std::bit_cast<std::uint32_t>(now[plane]);
            to[8 * width_ + row] = std::bit_cast<std::uint32_t>(next[plane] - now[plane]);
          }
        to[6 * width_ + k] = (at & kLeafBit) | std::uint32_t((at & ~kLeafBit) * steps_);
        to[7 * width_ + k] = word(node, 7 * width_ + k);
      }
    }
  }

  void write_leaf(std::size_t leaf, DeviceVector<std::uint32_t>& leaves) const {
    const std::uint32_t* const from = accel_.leaves.data() + leaf * std::size_t{kBlockWords};
    for (std::size_t step = 0; step < steps_; ++step) {
      std::uint32_t* const to = leaves.data() + (leaf * steps_ + step) * kMovingBlockWords;
      for (std::size_t i = 0; i < kBlock; ++i) {
        const std::uint32_t triangle = from[kBlockTriangles + i];
        const bool is_there = triangle != EK_NO_HIT;
        to[kBlockTriangles + i] = triangle;
        to[kBlockWords + kBlockTriangles + i] = is_there ? bounds_.first_record(triangle) : 0;
        for (std::size_t k = 0; k < 9; ++k) {
          constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
          const float now = is_there ? bounds_.corners(triangle, step)[k] : kNone;
          const float next = is_there ? bounds_.corners(triangle, step + 1)[k] : kNone;
          to[kBlock * k + i] = std::bit_cast<std::uint32_t>(now);
          to[kBlockWords + kBlock * k + i] = std::bit_cast<std::uint32_t>(next - now);
        }
      }
    }
  }

  const Accel& accel_;
  std::size_t width_, node_count_, leaf_count_, steps_;
  PoseBounds bounds_;
  std::vector<PoseBoxes> of_node_;
};

}  // namespace

void fit_wide_to_poses(Accel& accel, const TrianglePoses& poses) {
  WidePoseFitter(accel, accel.layout == "bvh16" ? 16 : 8, poses).fit(accel);
}

}  // namespace eikon
