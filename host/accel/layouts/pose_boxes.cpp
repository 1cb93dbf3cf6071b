// SPDX-License-Identifier: Apache-2.0
#include "accel/layouts/pose_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "accel/binary_tree.h"

namespace eikon {
namespace {

float moved_outwards(float x, double way) {
  if (way == 0) return x;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return std::nextafter(float(double{x} + way), way < 0 ? -kInfinity : kInfinity);
}

}  // namespace

PoseBounds::PoseBounds(const TrianglePoses& poses, std::span<const std::uint32_t> triangles) : poses_(poses) {
  for (const std::uint32_t triangle : triangles)
    for (std::size_t pose = 0; pose < poses.count; ++pose)
      for (int k = 0; k < 9; ++k) farthest_ = std::max(farthest_, std::abs(corners(triangle, pose)[k]));
}

void PoseBounds::add(std::uint32_t triangle, PoseBoxes& boxes) const {
  for (std::size_t pose = 0; pose < boxes.size(); ++pose) boxes[pose].add(triangle_box(corners(triangle, pose)));
}

bool PoseBounds::moves(const PoseBoxes& boxes) {
  const auto differs = [&](const Box& box) {
    for (int axis = 0; axis < 3; ++axis)
      if (box.lo[axis] != boxes[0].lo[axis] || box.hi[axis] != boxes[0].hi[axis]) return true;
    return false;
  };
  return std::ranges::any_of(boxes, differs);
}

/// With u = 2^-24 and all coordinates within M, a coordinate of a corner or of a plane is off by at
/// most 5 u M where kernels interpolate it: 2 u M for the difference, as much for its product with
/// the share, and u M for the sum. So a plane that lies 16 u M further out stays outside of every
/// corner. A missing box gets finite planes, because infinite ones have no difference.
std::array<float, 6> PoseBounds::planes(const PoseBoxes& boxes, std::size_t pose) const {
  const double margin = moves(boxes) ? 0x1p-20 * double{farthest_} : 0;
  constexpr float kMost = std::numeric_limits<float>::max();
  std::array<float, 6> planes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float lo = boxes[pose].lo[axis], hi = boxes[pose].hi[axis];
    planes[axis] = lo > hi ? kMost : moved_outwards(lo, -margin);
    planes[3 + axis] = lo > hi ? -kMost : moved_outwards(hi, margin);
  }
  return planes;
}

}  // namespace eikon
