// SPDX-License-Identifier: Apache-2.0
// Convex polygons and solids in double precision that are cut by planes: the cells of a BSP tree
// and their triangles.
#pragma once
#include <array>
#include <vector>

namespace eikon {

using Point3 = std::array<double, 3>;
[[nodiscard]] inline Point3 minus(const Point3& a, const Point3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline double dot(const Point3& a, const Point3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
using Polygon = std::vector<Point3>;  // corners in order

struct HalfSpace {  // normal * x >= offset
  Point3 normal;
  double offset;
  [[nodiscard]] double height(const Point3& x) const {
    return dot(normal, x) - offset;
  }
  [[nodiscard]] HalfSpace opposite() const { return {{-normal[0], -normal[1], -normal[2]}, -offset}; }
};

/// The part of a convex polygon whose height is at least `least`; may be empty.
[[nodiscard]] Polygon clipped(const Polygon& polygon, const HalfSpace& half, double least);

/// A convex solid, given by its faces, all with the same sense of rotation.
struct Solid {
  std::vector<Polygon> faces;
  [[nodiscard]] double area() const;
};

[[nodiscard]] Solid box_solid(const Point3& lo, const Point3& hi);

/// Surface areas of the parts in front of a plane and behind it, both with the cut.
struct CutAreas {
  double front, behind;
};
[[nodiscard]] CutAreas cut_areas(const Solid& solid, const HalfSpace& half);

/// The part in front of the plane.
[[nodiscard]] Solid clipped(const Solid& solid, const HalfSpace& half);

}  // namespace eikon
