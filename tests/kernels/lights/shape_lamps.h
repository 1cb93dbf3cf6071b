// SPDX-License-Identifier: Apache-2.0
// Emissive shapes: their material, programs that sample them, points spread over them, and cells of
// their surface.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "kernels/probe.h"
#include "pack/features.h"
#include "scene/scene.h"
#include "scene/shape.h"

namespace eikon::test {

inline Material lamp_material() {
  Material material;
  material.metallic = 0;
  material.specular = 0;
  material.emission = glm::vec3(1);
  material.double_sided = true;
  return material;
}

/// A probe in the program of a scene, without a tree.
inline Probe lamp_probe(const std::string& subject, const Features& features) {
  Probe probe(subject);
  for (const auto& [name, value] : features.defines()) probe.define(name, value);
  probe.define("EK_SMALL_TREE", "1")
      .define("EK_MEDIUM_TREE", "0")
      .define("EK_LARGE_TREE", "0")
      .define("EK_STACK_SIZE", "64");
  for (const char* name : {"none", "bvh16", "bvh8", "bvh2", "bvh4", "cwbvh", "grid", "octree", "kdtree", "bsp"})
    probe.define(std::string("EK_LAYOUT_") + name, std::string(name) == "none" ? "1" : "0");
  return probe;
}

/// Points spread evenly over a shape, in the world, each with its normal times the area that it
/// stands for: rows and columns of each part, which begin and end with it.
/// coarser  the number of rows and of columns is divided by this power of two, up to 64
struct ShapePoints {
  std::vector<glm::dvec3> p, area;

  explicit ShapePoints(const Shape& shape, int coarser = 1) : own_(own_shape(shape)), coarser_(coarser) {
    const std::array<double, 3>& size = own_.parameters;
    const auto face = [&](int axis, double side) {
      spread(512, 512, 4, [=](double u, double v) {
        glm::dvec3 n(0), q(0);
        n[axis] = side;
        q[axis] = side, q[(axis + 1) % 3] = 2 * u - 1, q[(axis + 2) % 3] = 2 * v - 1;
        return std::pair(q, n);
      });
    };
    // Of radius a + b y between two heights; area even in the square of the radius, here by weight.
    const auto side = [&](double a, double b, double low, double high) {
      const double slant = std::sqrt(1 + b * b);
      spread(256, 4096, 2 * std::numbers::pi * (high - low) * slant, [=](double u, double v) {
        const double y = low + (high - low) * u, phi = 2 * std::numbers::pi * v, r = a + b * y;
        return std::pair(glm::dvec3(r * std::cos(phi), y, r * std::sin(phi)),
                         r * glm::dvec3(std::cos(phi), -b, std::sin(phi)) / slant);
      });
    };
    const auto ball = [&](double center, double radius, double low, double high) {
      if (!(high > low)) return;
      spread(512, 1024, 2 * std::numbers::pi * radius * radius * (high - low), [=](double u, double v) {
        const double y = low + (high - low) * u, s = std::sqrt(1 - y * y), phi = 2 * std::numbers::pi * v;
        const glm::dvec3 n(s * std::cos(phi), y, s * std::sin(phi));
        return std::pair(glm::dvec3(0, center, 0) + radius * n, n);
      });
    };
    const auto disc = [&](double y, double radius) {
      spread(512, 1024, std::numbers::pi * radius * radius, [=](double u, double v) {
        const double r = radius * std::sqrt(u), phi = 2 * std::numbers::pi * v;
        return std::pair(glm::dvec3(r * std::cos(phi), y, r * std::sin(phi)), glm::dvec3(0, y, 0));
      });
    };
    if (shape.kind == ShapeKind::sphere) ball(0, 1, -1, 1);
    if (shape.kind == ShapeKind::plane)
      spread(1024, 1024, 4,
             [](double u, double v) { return std::pair(glm::dvec3(2 * u - 1, 0, 2 * v - 1), glm::dvec3(0, 1, 0)); });
    for (int axis = 0; axis < 3 && shape.kind == ShapeKind::box; ++axis) face(axis, -1), face(axis, 1);
    if (shape.kind == ShapeKind::cylinder)
      side(size[0], size[1], -1, 1), disc(-1, size[0] - size[1]), disc(1, size[0] + size[1]);
    if (shape.kind == ShapeKind::capsule) {
      const double tilt = (size[2] - size[1]) / (2 * size[0]), flat = std::sqrt(1 - tilt * tilt);
      side(0.5 * (size[1] + size[2]) / flat, -tilt / flat, size[2] * tilt - size[0], size[1] * tilt + size[0]);
      ball(-size[0], size[2], -1, tilt);
      ball(size[0], size[1], tilt, 1);
    }
  }

 private:
  template <class At>
  void spread(int fine_rows, int fine_columns, double own_area, At point) {
    const int rows = fine_rows / coarser_, columns = fine_columns / coarser_;
    const glm::dmat3& w = own_.world_from_own;
    const glm::dmat3 cofactor(glm::cross(w[1], w[2]), glm::cross(w[2], w[0]), glm::cross(w[0], w[1]));
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const auto [q, n] = point((i + 0.5) / rows, (j + 0.5) / columns);
        p.push_back(own_.center + w * q);
        area.push_back(own_area / (double(rows) * columns) * (cofactor * n));
      }
  }
  OwnShape own_;
  int coarser_;
};

/// Number of the cell, of `count` over [0, 1], that x lies in; then the same of an angle over a
/// turn.
inline std::size_t cell_of_unit(double x, std::size_t count) {
  return std::min(std::size_t(std::max(x, 0.0) * double(count)), count - 1);
}
inline std::size_t cell_of_turn(double y, double x, std::size_t count) {
  const double turn = std::atan2(y, x) / (2 * std::numbers::pi);
  return cell_of_unit(turn < 0 ? turn + 1 : turn, count);
}

/// Cells of a lamp's surface: rows and columns of each of its parts, as ShapePoints has them.
class SurfaceCells {
 public:
  static constexpr std::size_t kRows = 8, kColumns = 16, kCount = 6 * kRows * kColumns;

  explicit SurfaceCells(const Shape& shape)
      : kind_(shape.kind), own_(own_shape(shape)), own_from_world_(glm::inverse(own_.world_from_own)) {}

  [[nodiscard]] glm::dvec3 own(const glm::dvec3& p) const { return own_from_world_ * (p - own_.center); }

  [[nodiscard]] std::size_t of(const glm::dvec3& p) const {
    const glm::dvec3 q = own(p);
    const std::array<double, 3>& s = own_.parameters;
    const double r2 = q.x * q.x + q.z * q.z;
    if (kind_ == ShapeKind::plane) return number(0, 0.5 + 0.5 * q.x, cell_of_unit(0.5 + 0.5 * q.z, kColumns));
    if (kind_ == ShapeKind::box) return of_box(q);
    if (kind_ == ShapeKind::sphere) return around(0, 0.5 + 0.5 * q.y, q);
    if (kind_ == ShapeKind::cylinder) {
      const bool is_side = std::abs(q.y) < 1 - 2e-5;  // rounding moves points of the discs by less
      const double radius = s[0] + (q.y > 0 ? s[1] : -s[1]);
      return is_side ? around(0, 0.5 + 0.5 * q.y, q) : around(q.y < 0 ? 1 : 2, r2 / (radius * radius), q);
    }
    // A capsule: the circles where its side touches the balls.
    const double tilt = (s[2] - s[1]) / (2 * s[0]), low = s[2] * tilt - s[0], high = s[1] * tilt + s[0];
    if (q.y < low) return around(1, ((q.y + s[0]) / s[2] + 1) / (tilt + 1), q);
    if (q.y > high) return around(2, ((q.y - s[0]) / s[1] - tilt) / (1 - tilt), q);
    return around(0, (q.y - low) / (high - low), q);
  }

 private:
  [[nodiscard]] static std::size_t number(std::size_t part, double row, std::size_t column) {
    return (part * kRows + cell_of_unit(row, kRows)) * kColumns + column;
  }
  [[nodiscard]] static std::size_t around(std::size_t part, double row, const glm::dvec3& q) {
    return number(part, row, cell_of_turn(q.z, q.x, kColumns));
  }
  [[nodiscard]] static std::size_t of_box(const glm::dvec3& q) {
    const glm::dvec3 size = glm::abs(q);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t face = std::size_t(2 * axis) + (q[axis] > 0 ? 1 : 0);
    return number(face, 0.5 + 0.5 * q[(axis + 1) % 3], cell_of_unit(0.5 + 0.5 * q[(axis + 2) % 3], kColumns));
  }

  ShapeKind kind_;
  OwnShape own_;
  glm::dmat3 own_from_world_;
};

}  // namespace eikon::test
