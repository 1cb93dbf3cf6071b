// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/shapes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "scene/endless.h"
#include "io/text.h"
#include "scene/limits.h"

namespace eikon {
namespace {

constexpr double kMinSize = 0x1p-60;  // kernels square the inverse

/// The shape in the document's list that an extension names by its index.
const Json& listed_shape(const Json& document, const JsonView& view) {
  const Json* const all = as_object({.value = document, .kind = "document"}, "extensions");
  const Json* const list =
      all == nullptr ? nullptr : as_object({.value = *all, .kind = "extensions"}, kShapeListExtension);
  const Json* const shapes =
      list == nullptr ? nullptr : as_array({.value = *list, .kind = kShapeListExtension}, "shapes");
  const std::size_t count = shapes == nullptr ? 0 : size_of(*shapes);
  // Refuses any of a list that is not there.
  const std::size_t index = as_index(view, "shape", count, "shape").value_or(0);
  return element(*shapes, index);
}

const ShapeKindInfo& kind_of(const JsonView& view) {
  const std::string* const type = as_string(view, "type");
  std::vector<std::string> names;
  for (const ShapeKindInfo& each : shape_kinds()) {
    if (type != nullptr && *type == each.name) return each;
    names.emplace_back(each.name);
  }
  view.refuse(fmt::format("'type' {}; there are {}", type == nullptr ? "is missing" : in_quotes(*type) + " is unknown",
                          fmt::join(names, ", ")));
}

double checked_size(const JsonView& view, const ShapeParameter& parameter, double value) {
  const bool zero = parameter.may_be_zero && value == 0;
  if (!zero && !(value >= kMinSize && value <= kMaxCoordinate))
    view.refuse(fmt::format("'{}' {:g} is not a size in metres, 2^-60 to 2^40", parameter.name, value));
  return value;
}

void read_sizes(const JsonView& view, const ShapeKindInfo& info, Shape& shape) {
  const Json* const found = as_object(view, info.name);
  const JsonView sizes{.value = found == nullptr ? empty_object() : *found, .kind = info.name, .parent = &view};
  std::size_t at = 0;
  for (const ShapeParameter& parameter : info.parameters) {
    if (parameter.count == 1) {
      const auto said = as_number(sizes, parameter.name);
      const bool endless = info.kind == ShapeKind::plane && !said;
      shape.size[at++] = endless ? kEndlessSize : checked_size(sizes, parameter, said.value_or(parameter.usual));
    } else if (parameter.count > 1) {
      const bool said = has_numbers(sizes, parameter.name, parameter.count);
      for (std::size_t i = 0; i < parameter.count; ++i)
        shape.size[at++] =
            checked_size(sizes, parameter, said ? number_at(*member(sizes.value, parameter.name), i) : parameter.usual);
    }
  }
}

/// Checks what sizes say together; those that are missing have their default values by now.
void check_together(const JsonView& sizes_of, const ShapeKindInfo& info, const Shape& shape) {
  const bool round = info.kind == ShapeKind::cylinder || info.kind == ShapeKind::capsule;
  if (round && shape.size[1] == 0 && shape.size[2] == 0)
    sizes_of.refuse("'radiusTop' and 'radiusBottom' are both 0: there is nothing to see");
}

/// True if kernels can hold the matrix and its inverse: it is finite and not flat.
bool is_solid(const OwnShape& own) {
  const glm::dmat3 inverse = glm::inverse(own.world_from_own);
  double least = 1e300, most = 0;
  for (int column = 0; column < 3; ++column) {
    const double a = glm::length(own.world_from_own[column]), b = glm::length(inverse[column]);
    if (!std::isfinite(a) || !std::isfinite(b)) return false;
    least = std::min(least, a);
    most = std::max({most, a, b});
  }
  return least > 0 && most <= 0x1p60;
}

}  // namespace

void add_shape(const Json& document, const PlacedNode& placed, MaterialReader& materials, Scene& scene, Notes& notes) {
  const JsonView& node = placed.node.view;
  if (extension_of(node.value, kShapeExtension) == nullptr) return;
  const JsonView extensions{.value = *member(node.value, "extensions"), .kind = "extensions", .parent = &node};
  const Json& json = *as_object(extensions, kShapeExtension);
  const JsonView view{.value = json, .kind = kShapeExtension, .parent = &node};
  const Json* const said = member(json, "shape");
  if (said == nullptr) view.refuse("'shape' is missing; it is an object, or an index into KHR_implicit_shapes");
  const Json& source = is_object(*said) ? *said : listed_shape(document, view);
  const JsonView shape_view{.value = source, .kind = "shape", .parent = &view};
  if (!is_object(source)) shape_view.fail("is not an object");
  const auto material = as_index(view, "material", count_of(document, "materials"), "material");

  Shape shape;
  shape.name = placed.node.shown_name();
  shape.world_from_object = placed.world_from_object;
  const ShapeKindInfo& info = kind_of(shape_view);
  shape.kind = info.kind;
  read_sizes(shape_view, info, shape);
  check_together(shape_view, info, shape);
  shape.material = materials.use(material);
  place_shape(node, std::move(shape), scene, notes);
}

void place_shape(const JsonView& node, Shape shape, Scene& scene, Notes& notes) {
  const OwnShape own = own_shape(shape);
  if (!is_solid(own))
    return notes.warn(node.label() + ": its shape is left out, the node scales it to nothing or beyond all measure");
  const OwnShape bounded = own_shape(bounded_piece(shape));
  for (int axis = 0; axis < 3; ++axis) {
    const double farthest = std::abs(own.center[axis]) + bounded.half[axis];
    if (!(farthest <= kMaxCoordinate))
      node.refuse(
          fmt::format("its shape reaches {} = {:g}, beyond 2^40 m, the largest coordinate; scale the scene down",
                      "xyz"[axis], farthest));
  }
  scene.shapes.push_back(std::move(shape));
}

}  // namespace eikon
