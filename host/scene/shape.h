// SPDX-License-Identifier: Apache-2.0
// Surfaces that are no triangles: spheres and their like, placed by nodes with the extension
// EIKON_shape.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace eikon {

/// The kinds of kernels/shared/features.def.
enum class ShapeKind : std::uint32_t {
#define EK_SHAPE_KIND(name, bit) name = bit,
#include "shared/features.def"
};

inline constexpr std::size_t kShapeParameters = 3;

/// What a file may say of a kind, by the names of the draft KHR_implicit_shapes.
struct ShapeParameter {
  const char* name;       // "" ends the list
  double usual;           // where it is not said; metres
  std::size_t count = 1;  // numbers; they take so many places in Shape::size
  bool may_be_zero = false;
};
struct ShapeKindInfo {
  ShapeKind kind;
  const char* name;
  std::array<ShapeParameter, kShapeParameters> parameters;
};
[[nodiscard]] std::span<const ShapeKindInfo> shape_kinds();
[[nodiscard]] const ShapeKindInfo& shape_kind(ShapeKind kind);

/// A shape as a node places it.
struct Shape {
  std::string name;  // of the node, or "node 3" if the file has none
  ShapeKind kind{};
  // Metres of the node's space, in the order of shape_kinds(); implicit: half the bounds.
  std::array<double, kShapeParameters> size{};
  glm::dvec3 middle{0.0};                       // implicit: of the bounds
  std::uint32_t formula = 0;                    // implicit: index into Scene::formulas
  glm::dmat4 world_from_object{1.0};
  std::uint32_t material = 0;     // index into Scene::materials
  std::uint32_t light_group = 0;  // of what it emits; 0: the material's
};

/// A shape as kernels/shape_<name>.h has it: of standard size in a space of its own.
struct OwnShape {
  glm::dmat3 world_from_own{1.0};
  glm::dvec3 center{0.0};              // world
  std::array<double, 3> parameters{};  // a, b, c
  glm::dvec3 half{0.0};                // half the extent of the world's box about the centre
};
[[nodiscard]] OwnShape own_shape(const Shape& shape);

}  // namespace eikon
