// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/polytope.h"

#include <algorithm>
#include <cmath>

namespace eikon {
namespace {

double length(const Point3& a) { return std::sqrt(dot(a, a)); }

double polygon_area(const Polygon& p) {
  Point3 sum{};
  for (std::size_t i = 2; i < p.size(); ++i) {
    const Point3 c = cross(minus(p[i - 1], p[0]), minus(p[i], p[0]));
    for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
  }
  return 0.5 * length(sum);
}

/// Does the same as clipped(), and finds the two points where the polygon's border passes the
/// height, if it does.
Polygon clipped(const Polygon& polygon, const HalfSpace& half, double least, Polygon* passes) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ha = half.height(a) - least, hb = half.height(b) - least;
    if (ha >= 0) kept.push_back(a);
    if ((ha >= 0) == (hb >= 0)) continue;
    const double w = ha / (ha - hb);
    const Point3 p{a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1]), a[2] + w * (b[2] - a[2])};
    kept.push_back(p);
    if (passes != nullptr) passes->push_back(p);
  }
  return kept;
}

}  // namespace

Polygon clipped(const Polygon& polygon, const HalfSpace& half, double least) {
  return clipped(polygon, half, least, nullptr);
}

double Solid::area() const {
  double sum = 0;
  for (const Polygon& face : faces) sum += polygon_area(face);
  return sum;
}

Solid box_solid(const Point3& lo, const Point3& hi) {
  Solid solid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const bool upper : {false, true}) {
      Polygon face(4);
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t corner = upper ? i : 3 - i;
        face[i][axis] = upper ? hi[axis] : lo[axis];
        face[i][u] = corner == 1 || corner == 2 ? hi[u] : lo[u];
        face[i][v] = corner >= 2 ? hi[v] : lo[v];
      }
      solid.faces.push_back(face);
    }
  }
  return solid;
}

CutAreas cut_areas(const Solid& solid, const HalfSpace& half) {
  double front = 0, all = 0;
  Polygon border;
  for (const Polygon& face : solid.faces) {
    all += polygon_area(face);
    front += polygon_area(clipped(face, half, 0, &border));
  }
  // Each face gives a segment of the cut's border; the triangles from one point of it to them all
  // fill the cut.
  double cut = 0;
  for (std::size_t i = 0; i + 1 < border.size(); i += 2)
    cut += 0.5 * length(cross(minus(border[i], border[0]), minus(border[i + 1], border[0])));
  return {front + cut, all - front + cut};
}

Solid clipped(const Solid& solid, const HalfSpace& half) {
  Solid part;
  Polygon border;
  for (const Polygon& face : solid.faces) {
    Polygon kept = clipped(face, half, 0, &border);
    if (kept.size() >= 3) part.faces.push_back(std::move(kept));
  }
  if (border.size() < 3) return part;
  Point3 middle{};
  for (const Point3& p : border)
    for (std::size_t k = 0; k < 3; ++k) middle[k] += p[k] / static_cast<double>(border.size());
  std::size_t most = 0;  // axis of the largest component of the normal
  for (std::size_t k = 1; k < 3; ++k) most = std::abs(half.normal[k]) > std::abs(half.normal[most]) ? k : most;
  const std::size_t u = (most + 1) % 3, v = (most + 2) % 3;
  std::sort(border.begin(), border.end(), [&](const Point3& a, const Point3& b) {
    return std::atan2(a[v] - middle[v], a[u] - middle[u]) < std::atan2(b[v] - middle[v], b[u] - middle[u]);
  });
  Polygon cap;
  for (std::size_t i = 0; i < border.size(); ++i)
    if (cap.empty() || border[i] != cap.back()) cap.push_back(border[i]);
  if (cap.size() >= 3) part.faces.push_back(std::move(cap));
  return part;
}

}  // namespace eikon
