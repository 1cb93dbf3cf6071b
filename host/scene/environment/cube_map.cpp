// SPDX-License-Identifier: Apache-2.0
#include "scene/environment/cube_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace eikon {
namespace {

enum class Face : std::uint8_t { right, left, up, down, ahead, behind };

/// Where a face lies, in sides of faces from the upper left.
struct Place {
  std::uint32_t column, row;
  bool turned = false;  // by half a turn
};
using Places = std::array<Place, 6>;  // in the order of Face

constexpr Places kHorizontalCross{{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}};
constexpr Places kVerticalCross{{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3, true}}};
constexpr Places kRow{{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}};
constexpr Places kColumn{{{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}};
// OpenEXR looks along +Z with +X on its left.
constexpr Places kOpenExr{{{0, 1}, {0, 0}, {0, 2, true}, {0, 3, true}, {0, 4}, {0, 5}}};

const Places& places_of(CubeLayout layout) {
  switch (layout) {
    case CubeLayout::horizontal_cross:
      return kHorizontalCross;
    case CubeLayout::vertical_cross:
      return kVerticalCross;
    case CubeLayout::row:
      return kRow;
    case CubeLayout::column:
      return kColumn;
    case CubeLayout::openexr:
      break;
  }
  return kOpenExr;
}

/// A point of a face: s to the right and t down, both from -1 to 1.
struct FacePoint {
  Face face;
  double s, t;
};

FacePoint meet(const glm::dvec3& d) {
  using enum Face;
  const glm::dvec3 size = glm::abs(d);
  if (size.x >= size.y && size.x >= size.z)
    return d.x > 0 ? FacePoint{right, d.z / size.x, -d.y / size.x} : FacePoint{left, -d.z / size.x, -d.y / size.x};
  if (size.y >= size.z)
    return d.y > 0 ? FacePoint{up, d.x / size.y, -d.z / size.y} : FacePoint{down, d.x / size.y, d.z / size.y};
  return d.z < 0 ? FacePoint{ahead, d.x / size.z, -d.y / size.z} : FacePoint{behind, -d.x / size.z, -d.y / size.z};
}

class Cube {
 public:
  Cube(CubeLayout layout, std::uint32_t width, const std::vector<glm::vec3>& texels)
      : places_(places_of(layout)), side_(face_side(layout, width)), width_(width), texels_(texels) {}

  /// Interpolated between the texels of a face.
  [[nodiscard]] glm::dvec3 seen(const glm::dvec3& direction) const {
    const FacePoint at = meet(direction);
    const Place& place = places_[static_cast<std::size_t>(at.face)];
    const double sign = place.turned ? -1 : 1, last = side_ - 1.0;
    const double x = std::clamp((sign * at.s + 1) / 2 * side_ - 0.5, 0.0, last);
    const double y = std::clamp((sign * at.t + 1) / 2 * side_ - 0.5, 0.0, last);
    const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
    const std::uint32_t next_column = std::min(column + 1, side_ - 1), next_row = std::min(row + 1, side_ - 1);
    const auto texel = [&](std::uint32_t i, std::uint32_t j) {
      return glm::dvec3(texels_[std::size_t{place.row * side_ + j} * width_ + place.column * side_ + i]);
    };
    const glm::dvec3 upper = glm::mix(texel(column, row), texel(next_column, row), x - column);
    const glm::dvec3 lower = glm::mix(texel(column, next_row), texel(next_column, next_row), x - column);
    return glm::mix(upper, lower, y - row);
  }

 private:
  const Places& places_;
  std::uint32_t side_, width_;
  const std::vector<glm::vec3>& texels_;
};

bool beside_is_plain(CubeLayout layout, std::uint32_t width, std::uint32_t height, const std::vector<glm::vec3>& rgb) {
  const std::uint32_t side = face_side(layout, width);
  const Places& places = places_of(layout);
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    const auto column = static_cast<std::uint32_t>(i % width) / side,
               row = static_cast<std::uint32_t>(i / width) / side;
    const bool on_face =
        std::ranges::any_of(places, [&](const Place& p) { return p.column == column && p.row == row; });
    if (!on_face && rgb[i] != rgb[std::size_t{height} * width - 1]) return false;
  }
  return true;
}

}  // namespace

std::optional<CubeLayout> cube_layout(std::uint32_t width, std::uint32_t height, const std::vector<glm::vec3>& rgb,
                                      bool is_openexr) {
  const std::uint64_t w = width, h = height;
  if (h == 6 * w) return is_openexr ? CubeLayout::openexr : CubeLayout::column;
  if (w == 6 * h) return CubeLayout::row;
  if (w * 3 == h * 4 && beside_is_plain(CubeLayout::horizontal_cross, width, height, rgb))
    return CubeLayout::horizontal_cross;
  if (w * 4 == h * 3 && beside_is_plain(CubeLayout::vertical_cross, width, height, rgb))
    return CubeLayout::vertical_cross;
  return std::nullopt;
}

const char* name_of(CubeLayout layout) {
  switch (layout) {
    case CubeLayout::horizontal_cross:
      return "horizontal cross";
    case CubeLayout::vertical_cross:
      return "vertical cross";
    case CubeLayout::row:
      return "row";
    case CubeLayout::column:
      return "column";
    case CubeLayout::openexr:
      break;
  }
  return "column in OpenEXR's order";
}

std::uint32_t face_side(CubeLayout layout, std::uint32_t width) {
  const std::uint32_t columns = layout == CubeLayout::horizontal_cross ? 4
                                : layout == CubeLayout::vertical_cross ? 3
                                : layout == CubeLayout::row            ? 6
                                                                       : 1;
  return width / columns;
}

std::vector<glm::vec3> equirectangular(CubeLayout layout, std::uint32_t width, const std::vector<glm::vec3>& cube) {
  const Cube seen_from(layout, width, cube);
  const std::uint32_t rows = 2 * face_side(layout, width), columns = 2 * rows;
  std::vector<glm::vec3> map(std::size_t{rows} * columns);
  tbb::parallel_for(std::uint32_t{0}, rows, [&](std::uint32_t row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      // The mean of four directions: a texel of a face fills less of the sphere at its corners.
      glm::dvec3 sum(0);
      for (std::uint32_t part = 0; part < 4; ++part) {
        const double polar = std::numbers::pi * (row + 0.25 + 0.5 * (part / 2)) / rows;
        const double turn = 2 * std::numbers::pi * ((column + 0.25 + 0.5 * (part % 2)) / columns - 0.5);
        sum += seen_from.seen({std::sin(turn) * std::sin(polar), std::cos(polar), -std::cos(turn) * std::sin(polar)});
      }
      map[std::size_t{row} * columns + column] = glm::vec3(sum / 4.0);
    }
  });
  return map;
}

}  // namespace eikon
