// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/shapes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "scene/endless.h"
#include "gltf/geometry/meshes.h"

namespace eikon {
namespace {

constexpr double kLeastSize = 0x1p-60;  // kernels square the inverse

/// The object of the list that is said by index.
const Json& listed_shape(const Json& document, const Place& place) {
  const Json* const all = as_object({.value = document, .kind = "document"}, "extensions");
  const Json* const list =
      all == nullptr ? nullptr : as_object({.value = *all, .kind = "extensions"}, kShapeListExtension);
  const Json* const shapes =
      list == nullptr ? nullptr : as_array({.value = *list, .kind = kShapeListExtension}, "shapes");
  const std::size_t count = shapes == nullptr ? 0 : shapes->size();
  return (*shapes)[as_index(place, "shape", count, "shape").value_or(0)];
}

const ShapeKindInfo& kind_of(const Place& place) {
  check_string(place, "type");
  const Json* const type = member(place.value, "type");
  std::vector<std::string> names;
  for (const ShapeKindInfo& each : shape_kinds()) {
    if (type != nullptr && *type == each.name) return each;
    names.emplace_back(each.name);
  }
  place.refuse(
      fmt::format("'type' {}; there are {}",
                  type == nullptr ? "is missing" : in_quotes(type->get_ref<const std::string&>()) + " is unknown",
                  fmt::join(names, ", ")));
}

double checked_size(const Place& place, const ShapeParameter& parameter, double value) {
  const bool zero = parameter.may_be_zero && value == 0;
  if (!zero && !(value >= kLeastSize && value <= kMaxCoordinate))
    place.refuse(fmt::format("'{}' {:g} is not a size in metres, 2^-60 to 2^40", parameter.name, value));
  return value;
}

void read_sizes(const Place& place, const ShapeKindInfo& info, Shape& shape) {
  static const Json kDefaults = Json::object();
  const Json* const found = as_object(place, info.name);
  const Place sizes{.value = found == nullptr ? kDefaults : *found, .kind = info.name, .parent = &place};
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
            checked_size(sizes, parameter, said ? sizes.value[parameter.name][i].get<double>() : parameter.usual);
    }
  }
}

/// What parameters say together; those that are missing have their usual values by now.
void check_together(const Place& sizes_of, const ShapeKindInfo& info, const Shape& shape) {
  const bool round = info.kind == ShapeKind::cylinder || info.kind == ShapeKind::capsule;
  if (round && shape.size[1] == 0 && shape.size[2] == 0)
    sizes_of.refuse("'radiusTop' and 'radiusBottom' are both 0: there is nothing to see");
}

/// Whether kernels can hold the matrix and its inverse: finite, and not flat.
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

bool has_shape(const Json& node) {
  const Json* const extensions = member(node, "extensions");
  return extensions != nullptr && member(*extensions, kShapeExtension) != nullptr;
}

void add_shape(const Json& document, const Place& node, const std::string& name, const glm::dmat4& world_from_object,
               const std::function<std::uint32_t(int)>& use_material, Scene& scene, Notes& notes) {
  const Place extensions{.value = node.value["extensions"], .kind = "extensions", .parent = &node};
  const Json& json = *as_object(extensions, kShapeExtension);
  const Place place{.value = json, .kind = kShapeExtension, .parent = &node};
  const Json* const said = member(json, "shape");
  if (said == nullptr) place.refuse("'shape' is missing; it is an object, or an index into KHR_implicit_shapes");
  const Json& source = said->is_object() ? *said : listed_shape(document, place);
  const Place shape_place{.value = source, .kind = "shape", .parent = &place};
  if (!source.is_object()) shape_place.fail("is not an object");
  const auto material = as_index(place, "material", items(document, "materials").size(), "material");

  Shape shape;
  shape.name = name;
  shape.world_from_object = world_from_object;
  const ShapeKindInfo& info = kind_of(shape_place);
  shape.kind = info.kind;
  read_sizes(shape_place, info, shape);
  check_together(shape_place, info, shape);
  shape.material = use_material(material ? static_cast<int>(*material) : -1);
  place_shape(node, std::move(shape), scene, notes);
}

void place_shape(const Place& node, Shape shape, Scene& scene, Notes& notes) {
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
