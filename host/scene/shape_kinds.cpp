// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/endless.h"
#include "scene/shape.h"

namespace eikon {
namespace {

constexpr ShapeParameter kNone{.name = "", .usual = 0, .count = 0};

constexpr std::array kKinds{
    ShapeKindInfo{ShapeKind::sphere, "sphere", {ShapeParameter{.name = "radius", .usual = 0.5}, kNone, kNone}},
    ShapeKindInfo{ShapeKind::box, "box", {ShapeParameter{.name = "size", .usual = 1, .count = 3}, kNone, kNone}},
    ShapeKindInfo{ShapeKind::plane,
                  "plane",
                  {ShapeParameter{.name = "sizeX", .usual = 1}, ShapeParameter{.name = "sizeZ", .usual = 1}, kNone}},
    ShapeKindInfo{ShapeKind::cylinder,
                  "cylinder",
                  {ShapeParameter{.name = "height", .usual = 0.5},
                   ShapeParameter{.name = "radiusTop", .usual = 0.25, .may_be_zero = true},
                   ShapeParameter{.name = "radiusBottom", .usual = 0.25, .may_be_zero = true}}},
    ShapeKindInfo{ShapeKind::capsule,
                  "capsule",
                  {ShapeParameter{.name = "height", .usual = 0.5, .may_be_zero = true},
                   ShapeParameter{.name = "radiusTop", .usual = 0.25, .may_be_zero = true},
                   ShapeParameter{.name = "radiusBottom", .usual = 0.25, .may_be_zero = true}}},
};

glm::dvec3 row(const glm::dmat3& m, int i) { return {m[0][i], m[1][i], m[2][i]}; }

// Its own space is that of the formula, about the middle of the bounds; `half` is the extent of the
// bounds in the world.
OwnShape own_implicit(const Shape& shape) {
  OwnShape own;
  own.world_from_own = glm::dmat3(shape.world_from_object);
  own.center = glm::dvec3(shape.world_from_object * glm::dvec4(shape.middle, 1));
  for (std::size_t i = 0; i < 3; ++i) own.parameters[i] = shape.size[i];
  const glm::dvec3 half(shape.size[0], shape.size[1], shape.size[2]);
  for (int axis = 0; axis < 3; ++axis) own.half[axis] = glm::dot(glm::abs(row(own.world_from_own, axis)), half);
  return own;
}

/// Half the extent of a shape along an axis of the world, whose row of world_from_own is r.
double half_extent(ShapeKind kind, const std::array<double, 3>& p, const glm::dvec3& r) {
  const glm::dvec3 size = glm::abs(r);
  switch (kind) {
    case ShapeKind::sphere:
      return glm::length(r);
    case ShapeKind::box:
      return size.x + size.y + size.z;
    case ShapeKind::plane:
      return p[0] * size.x + p[1] * size.z;
    case ShapeKind::cylinder:
      return size.y + std::max(p[0] + p[1], p[0] - p[1]) * std::hypot(r.x, r.z);
    case ShapeKind::capsule:
      return p[0] * size.y + std::max(p[1], p[2]) * glm::length(r);
    case ShapeKind::implicit:
      return p[0] * size.x + p[1] * size.y + p[2] * size.z;
  }
  return 0;
}

}  // namespace

std::span<const ShapeKindInfo> shape_kinds() { return kKinds; }

const ShapeKindInfo& shape_kind(ShapeKind kind) {
  const auto found = std::ranges::find(kKinds, kind, &ShapeKindInfo::kind);
  if (found == kKinds.end()) throw InternalError("a kind of shape is missing in shape_kinds.cpp");
  return *found;
}

OwnShape own_shape(const Shape& shape) {
  if (shape.kind == ShapeKind::implicit) return own_implicit(shape);
  OwnShape own;
  own.center = glm::dvec3(shape.world_from_object[3]);
  glm::dvec3 scale{1.0};
  const double top = shape.size[1], bottom = shape.size[2], widest = std::max(top, bottom);  // of cylinder and capsule
  switch (shape.kind) {
    case ShapeKind::sphere:
      scale = glm::dvec3(shape.size[0]);
      break;
    case ShapeKind::box:
      scale = 0.5 * glm::dvec3(shape.size[0], shape.size[1], shape.size[2]);
      break;
    case ShapeKind::plane: {
      const Shape piece = bounded_piece(shape);  // textures repeat every metre
      scale = {0.5 * piece.size[0], 0.5 * std::max(piece.size[0], piece.size[1]), 0.5 * piece.size[1]};
      const auto limit = [&](double size, int axis) {
        return std::isinf(size) ? kEndlessReach / (scale[axis] * glm::length(glm::dmat3(shape.world_from_object)[axis]))
                                : 1;
      };
      own.parameters = {limit(shape.size[0], 0), limit(shape.size[1], 2), 0};
      break;
    }
    case ShapeKind::cylinder:
      scale = {widest, 0.5 * shape.size[0], widest};
      own.parameters = {0.5 * (top + bottom) / widest, 0.5 * (top - bottom) / widest, 0};
      break;
    case ShapeKind::capsule:
      scale = glm::dvec3(widest);
      own.parameters = {0.5 * shape.size[0] / widest, top / widest, bottom / widest};
      break;
    case ShapeKind::implicit:
      break;
  }
  own.world_from_own = glm::dmat3(shape.world_from_object);
  for (int axis = 0; axis < 3; ++axis) own.world_from_own[axis] *= scale[axis];
  for (int axis = 0; axis < 3; ++axis)
    own.half[axis] = half_extent(shape.kind, own.parameters, row(own.world_from_own, axis));
  return own;
}

}  // namespace eikon
