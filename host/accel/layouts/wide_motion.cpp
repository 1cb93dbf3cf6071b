// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "accel/layouts/layouts.h"
#include "accel/layouts/pose_boxes.h"
#include "core/error.h"

namespace eikon {
namespace {

/// Makes of each node and each leaf of a wide tree a row of copies, one for each pose.
class WidePoseFitter {
 public:
  WidePoseFitter(const Accel& accel, std::size_t width, const TrianglePoses& poses)
      : accel_(accel),
        width_(width),
        node_count_(accel.nodes.size() / (8 * width)),
        leaf_count_(accel.leaves.size() / kBlockWords),
        bounds_(poses, triangles_of(accel)) {
    of_node_.resize(node_count_, PoseBoxes(poses.count));
    for (std::size_t n = node_count_; n-- > 0;)  // children come after their parents
      for (std::size_t k = 0; k < width_; ++k) {
        const PoseBoxes boxes = child(n, k);
        for (std::size_t pose = 0; pose < poses.count; ++pose) of_node_[n][pose].add(boxes[pose]);
      }
  }

  void fit(Accel& to) const {
    const std::size_t poses = bounds_.count();
    if (std::max(node_count_, leaf_count_) * poses >= kLeafBit)
      throw InputError("a tree of triangles that move has too many poses; use fewer --motion-steps");
    DeviceVector<std::uint32_t> nodes(accel_.nodes.size() * poses), leaves(accel_.leaves.size() * poses);
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
    const std::size_t poses = bounds_.count(), words = 8 * width_;
    for (std::size_t k = 0; k < width_; ++k) {
      const PoseBoxes boxes = child(node, k);
      const std::uint32_t at = word(node, 6 * width_ + k);
      const auto moved = std::uint32_t((at & ~kLeafBit) * poses);
      for (std::size_t pose = 0; pose < poses; ++pose) {
        std::uint32_t* const to = nodes.data() + (node * poses + pose) * words;
        const std::array<float, 6> planes = bounds_.planes(boxes, pose);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          to[2 * width_ * axis + k] = std::bit_cast<std::uint32_t>(planes[axis]);
          to[(2 * axis + 1) * width_ + k] = std::bit_cast<std::uint32_t>(planes[3 + axis]);
        }
        to[6 * width_ + k] = (at & kLeafBit) | moved;
        to[7 * width_ + k] = word(node, 7 * width_ + k);
      }
    }
  }

  void write_leaf(std::size_t leaf, DeviceVector<std::uint32_t>& leaves) const {
    const std::uint32_t* const from = accel_.leaves.data() + leaf * std::size_t{kBlockWords};
    const std::size_t poses = bounds_.count();
    for (std::size_t pose = 0; pose < poses; ++pose) {
      std::uint32_t* const to = leaves.data() + (leaf * poses + pose) * kBlockWords;
      for (std::size_t i = 0; i < kBlock; ++i) {
        const std::uint32_t triangle = from[kBlockTriangles + i];
        const bool names_record = triangle != EK_NO_HIT && pose + 1 == poses;
        to[kBlockTriangles + i] = names_record ? bounds_.first_record(triangle) : triangle;
        for (std::size_t k = 0; k < 9; ++k)
          to[kBlock * k + i] =
              triangle == EK_NO_HIT ? 0x7fc00000U : std::bit_cast<std::uint32_t>(bounds_.corners(triangle, pose)[k]);
      }
    }
  }

  const Accel& accel_;
  std::size_t width_, node_count_, leaf_count_;
  PoseBounds bounds_;
  std::vector<PoseBoxes> of_node_;
};

}  // namespace

void fit_wide_to_poses(Accel& accel, const TrianglePoses& poses) {
  WidePoseFitter(accel, accel.layout == "bvh16" ? 16 : 8, poses).fit(accel);
}

}  // namespace eikon
