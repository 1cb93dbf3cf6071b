// SPDX-License-Identifier: Apache-2.0
// Convex shapes in double precision.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "scene/shape.h"
#include "shared/records.h"

namespace eikon {

/// A shape's record in double precision. height() tells how far a point, in the shape's own space,
/// is inside the shape (negative) or outside, as a share of the shape's size.
struct Oracle {
  glm::dmat3 l{1.0};
  glm::dvec3 center{0.0};
  ShapeRecord record;
  explicit Oracle(const ShapeRecord& r) : record(r) {
    l = glm::transpose(
        glm::dmat3(glm::dvec3(r.x_x, r.x_y, r.x_z), glm::dvec3(r.y_x, r.y_y, r.y_z), glm::dvec3(r.z_x, r.z_y, r.z_z)));
    center = {r.center_x, r.center_y, r.center_z};
  }
  [[nodiscard]] double height(const glm::dvec3& p) const {
    switch (static_cast<ShapeKind>(record.kind)) {
      case ShapeKind::sphere:
        return glm::length(p) - 1;
      case ShapeKind::box:
        return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1;
      case ShapeKind::plane:     // has no inside
      case ShapeKind::implicit:  // has tests of its own
        return NAN;
      case ShapeKind::cylinder: {
        const double side = std::hypot(p.x, p.z) - (double(record.a) + double(record.b) * p.y);
        return std::max(side, std::abs(p.y) - 1);
      }
      case ShapeKind::capsule: {
        const double a = record.a, b = record.b, c = record.c, round = std::hypot(p.x, p.z);
        const double tilt = (c - b) / (2 * a);
        const double upper = std::hypot(round, p.y - a) - b, lower = std::hypot(round, p.y + a) - c;
        if (std::abs(tilt) >= 1) return std::min(upper, lower);
        const double flat = std::sqrt(1 - tilt * tilt),
                     along = p.y * flat - round * tilt;  // along the side from its middle
        const double low = -a * flat, high = a * flat;
        if (along > high) return upper;
        if (along < low) return lower;
        return round * flat + p.y * tilt - 0.5 * (b + c);
      }
    }
    return NAN;
  }
};

}  // namespace eikon
