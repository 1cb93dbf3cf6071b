// SPDX-License-Identifier: Apache-2.0
// Planes without end: Shape::size is infinite along an axis for which a file names no size. Rays
// meet them as far as 2^42 m from their middle. Whatever else depends on a scene's extent (framing,
// the precision of rays) takes the metre around that middle instead.
#pragma once
#include <cmath>
#include <limits>

#include "scene/shape.h"

namespace eikon {

inline constexpr double kEndlessSize = std::numeric_limits<double>::infinity();  // as Shape::size
inline constexpr double kEndlessReach = 0x1p42;                                  // metres; beyond kMaxCoordinate

[[nodiscard]] inline bool is_endless(const Shape& shape) {
  return shape.kind == ShapeKind::plane && (std::isinf(shape.size[0]) || std::isinf(shape.size[1]));
}

/// The same shape with one metre instead of each infinite size.
[[nodiscard]] inline Shape bounded_piece(Shape shape) {
  for (double& size : shape.size)
    if (std::isinf(size)) size = 1;
  return shape;
}

/// True if a box in the world belongs to a plane without end: everything else lies within
/// kMaxCoordinate (2^40 m).
/// corners  lo and hi, three floats each
[[nodiscard]] inline bool is_endless_box(const float* corners) {
  float farthest = 0;
  for (int i = 0; i < 6; ++i) farthest = std::fmax(farthest, std::fabs(corners[i]));
  return farthest > 0x1p41F;
}

}  // namespace eikon
