// SPDX-License-Identifier: Apache-2.0
// Planes without end: along an axis for which a file names no size, Shape::size is infinite. Rays meet them as far as 2^42 m from their
// middle; what else goes by a scene's extent (cameras that frame it, the precision of its rays) takes them for the metre there.
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

/// The metre that stands for what has no end; any other shape as it is.
[[nodiscard]] inline Shape bounded_piece(Shape shape) {
  for (double& size : shape.size)
    if (std::isinf(size)) size = 1;
  return shape;
}

/// Whether a box in the world is of something without end: what a file places lies within kMaxCoordinate (2^40 m).
/// corners  lo and hi, three floats each
[[nodiscard]] inline bool is_endless_box(const float* corners) {
  float farthest = 0;
  for (int i = 0; i < 6; ++i) farthest = std::fmax(farthest, std::fabs(corners[i]));
  return farthest > 0x1p41F;
}

}  // namespace eikon
