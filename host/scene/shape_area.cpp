// SPDX-License-Identifier: Apache-2.0
#include "scene/shape_area.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/transform.h"

namespace eikon {
namespace {

using std::numbers::pi;

// A linear map takes an area of unit normal n to one |cofactor * n| times as large.

/// The mean factor by which areas grow whose normals are (round cos a, y, round sin a), over all
/// angles a. The integrand is periodic, so equally spaced points converge faster than any power:
/// they are doubled until the mean stays. 64 are enough for an ellipsoid twice as long as wide, and
/// 2048 for the longest.
double ring_stretch(const glm::dmat3& cofactor, double round, double y) {
  constexpr int most = 2048;
  constexpr double same = 1e-15;
  const auto sum_of = [&](int count, double offset) {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * pi * (i + offset) / count;
      sum += glm::length(cofactor * glm::dvec3(round * std::cos(angle), y, round * std::sin(angle)));
    }
    return sum;
  };
  int count = 16;
  double sum = sum_of(count, 0), change = 1;
  while (count < most && change > same * sum) {
    const double between = sum_of(count, 0.5);
    change = std::abs(between - sum);
    sum += between;
    count *= 2;
  }
  return sum / count;
}

/// The mean of ring_stretch over the normals of a unit sphere whose y is between lo and hi.
double zone_stretch(const glm::dmat3& cofactor, double lo, double hi) {
  constexpr int count = 256;  // Gauss's rule of two points in each
  double sum = 0;
  for (int i = 0; i < count; ++i)
    for (const double place : {0.5 - std::sqrt(1 / 12.0), 0.5 + std::sqrt(1 / 12.0)}) {
      const double y = lo + (hi - lo) * (i + place) / count;
      sum += ring_stretch(cofactor, std::sqrt(std::max(0.0, 1 - y * y)), y);
    }
  return sum / (2 * count);
}

/// True if the map scales all lengths alike; `stretch` is then the factor of areas.
bool keeps_angles(const glm::dmat3& cofactor, double& stretch) {
  stretch = glm::length(cofactor[0]);
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 &a = cofactor[i], &b = cofactor[(i + 1) % 3];
    if (std::abs(glm::length(a) - stretch) > 1e-9 * stretch || std::abs(glm::dot(a, b)) > 1e-9 * stretch * stretch)
      return false;
  }
  return true;
}

std::array<double, 3> capsule_areas(const OwnShape& own, const glm::dmat3& cofactor) {
  // Decided in floats, as kernels/shapes/capsule.h does.
  const auto a = float(own.parameters[0]), b = float(own.parameters[1]), c = float(own.parameters[2]);
  const float tilt_f = (c - b) / (2.0F * a);
  const bool there = std::abs(tilt_f) < 0.99999F;
  const double rim = there ? double(tilt_f) : b > c ? -1 : 1;
  double uniform = 0;
  const bool alike = keeps_angles(cofactor, uniform);
  const auto zone = [&](double lo, double hi) {
    return hi > lo ? (alike ? uniform : zone_stretch(cofactor, lo, hi)) : 0;
  };
  const double lower = 2 * pi * double(c) * double(c) * (1 + rim) * zone(-1, rim);
  const double upper = 2 * pi * double(b) * double(b) * (1 - rim) * zone(rim, 1);
  if (!there) return {0, lower, upper};
  const double flat = std::sqrt((1 - rim) * (1 + rim)), length = (2 * double(a) + rim * (double(b) - double(c))) / flat;
  const double side = pi * (double(b) + double(c)) * flat * length;  // of radii b and c times flat
  return {side * (alike ? uniform : ring_stretch(cofactor, flat, rim)), lower, upper};
}

}  // namespace

std::array<double, 3> part_areas_m2(ShapeKind kind, const OwnShape& own) {
  const glm::dmat3 cofactor = cofactors(own.world_from_own);
  double uniform = 0;
  const bool alike = keeps_angles(cofactor, uniform);
  switch (kind) {
    case ShapeKind::sphere:
      return {4 * pi * (alike ? uniform : zone_stretch(cofactor, -1, 1)), 0, 0};
    case ShapeKind::box:
      return {8 * (glm::length(cofactor[0]) + glm::length(cofactor[1]) + glm::length(cofactor[2])), 0, 0};
    case ShapeKind::plane:
      return {4 * glm::length(cofactor[1]), 0, 0};
    case ShapeKind::cylinder: {
      const double a = own.parameters[0], b = own.parameters[1], slant = std::sqrt(1 + b * b);
      const double disc = pi * glm::length(cofactor[1]);
      return {4 * pi * a * slant * (alike ? uniform : ring_stretch(cofactor, 1 / slant, -b / slant)),
              disc * (a - b) * (a - b), disc * (a + b) * (a + b)};
    }
    case ShapeKind::capsule:
      return capsule_areas(own, cofactor);
    case ShapeKind::implicit:
      return {};
  }
  return {};
}

}  // namespace eikon
