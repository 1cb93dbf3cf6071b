// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/shape.h"

namespace eikon {
namespace {

constexpr ShapeParameter kNone{.name = "", .usual = 0, .count = 0};

constexpr std::array kKinds{
    ShapeKindInfo{ShapeKind::sphere, "sphere", {ShapeParameter{.name = "radius", .usual = 0.5}, kNone, kNone}},
};

glm::dvec3 row(const glm::dmat3& m, int i) { return {m[0][i], m[1][i], m[2][i]}; }

// The formula's coordinates about the middle of its bounds; their box as the world has it.
OwnShape own_implicit(const Shape& shape) {
  OwnShape own;
  own.world_from_own = glm::dmat3(shape.world_from_object);
  own.center = glm::dvec3(shape.world_from_object * glm::dvec4(shape.middle, 1));
  for (std::size_t i = 0; i < 3; ++i) own.parameters[i] = shape.size[i];
  const glm::dvec3 half(shape.size[0], shape.size[1], shape.size[2]);
  for (int axis = 0; axis < 3; ++axis) own.half[axis] = glm::dot(glm::abs(row(own.world_from_own, axis)), half);
  return own;
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
  switch (shape.kind) {
    case ShapeKind::sphere:
      scale = glm::dvec3(shape.size[0]);
      break;
    case ShapeKind::implicit:
      break;
  }
  own.world_from_own = glm::dmat3(shape.world_from_object);
  for (int axis = 0; axis < 3; ++axis) own.world_from_own[axis] *= scale[axis];
  for (int axis = 0; axis < 3; ++axis) own.half[axis] = glm::length(row(own.world_from_own, axis));
  return own;
}

}  // namespace eikon
