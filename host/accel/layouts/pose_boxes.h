// SPDX-License-Identifier: Apache-2.0
// Boxes of nodes at each pose of triangles that move: what the layouts over time share.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/accel.h"
#include "accel/box.h"

namespace eikon {

using PoseBoxes = std::vector<Box>;  // one per pose

/// Knows the triangles of a tree at each pose, and how far outside of them the planes of moving
/// boxes must lie.
class PoseBounds {
 public:
  /// triangles  all of the tree
  PoseBounds(const TrianglePoses& poses, std::span<const std::uint32_t> triangles);

  [[nodiscard]] std::size_t count() const { return poses_.count; }

  /// The first of a triangle's records of poses.
  [[nodiscard]] std::uint32_t first_record(std::uint32_t triangle) const { return poses_.motion[triangle] - 1; }

  /// The nine coordinates of a triangle's corners at a pose.
  [[nodiscard]] const float* corners(std::uint32_t triangle, std::size_t pose) const {
    return poses_.corners + poses_.stride * (first_record(triangle) + pose);
  }

  /// Widens the boxes by a triangle.
  void add(std::uint32_t triangle, PoseBoxes& boxes) const;

  /// True if the boxes of some poses differ.
  [[nodiscard]] static bool moves(const PoseBoxes& boxes);

  /// The planes lo x, y, z, hi x, y, z of the boxes at a pose. Where kernels let them go straight
  /// from pose to pose, every corner stays within.
  [[nodiscard]] std::array<float, 6> planes(const PoseBoxes& boxes, std::size_t pose) const;

 private:
  const TrianglePoses& poses_;
  float farthest_ = 0;
};

}  // namespace eikon
