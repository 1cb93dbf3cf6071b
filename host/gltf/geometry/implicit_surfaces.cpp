// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/implicit_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "formula/parse.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "gltf/geometry/shapes.h"
#include "scene/limits.h"

namespace eikon {
namespace {

constexpr double kMinExtent =
    0x1p-20;  // over the largest coordinate; in less, floats would tell only a few points apart

void read_bounds(const JsonView& view, Shape& shape) {
  if (!has_numbers(view, "bounds", 6))
    view.refuse("'bounds' is missing; six numbers say where to look: the least x, y, z, then the largest");
  const Json& bounds = *member(view.value, "bounds");
  double lo[3], hi[3], reach = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lo[axis] = number_at(bounds, axis), hi[axis] = number_at(bounds, 3 + axis);
    for (const double value : {lo[axis], hi[axis]})
      if (!(std::abs(value) <= kMaxCoordinate))
        view.refuse(fmt::format("'bounds' reach {} = {:g}; at most 2^40 either way", "xyz"[axis], value));
    reach = std::max({reach, std::abs(lo[axis]), std::abs(hi[axis])});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(hi[axis] > lo[axis]))
      view.refuse(
          fmt::format("'bounds' are empty: {} from {:g} to {:g}; first come the least x, y, z, then the largest",
                      "xyz"[axis], lo[axis], hi[axis]));
    if (!(hi[axis] - lo[axis] >= kMinExtent * reach))
      view.refuse(fmt::format("'bounds' from {:g} to {:g} in {} are too thin for single precision; move or widen them",
                              lo[axis], hi[axis], "xyz"[axis]));
    shape.middle[int(axis)] = 0.5 * (lo[axis] + hi[axis]);
    shape.size[axis] = 0.5 * (hi[axis] - lo[axis]);
  }
}

}  // namespace

std::uint32_t ImplicitSurfaceReader::formula(const JsonView& view) {
  const std::string* const f = as_string(view, "f");
  if (f == nullptr) view.refuse("'f' is missing; a formula of x, y and z, as in \"x^2 + y^2 + z^2 - 1\"");
  const auto [known, is_new] = known_.try_emplace(*f, std::uint32_t(scene_.formulas.size()));
  if (!is_new) return known->second;
  try {
    scene_.formulas.push_back(formula::parse_formula(*f));
  } catch (const InputError& error) {
    view.refuse(fmt::format("f: {}", error.what()));
  }
  node_count_ += scene_.formulas.back().expressions.size();
  if (node_count_ > kMaxFormulaNodes)
    view.refuse(
        fmt::format("f: with it the formulas of the scene and their derivatives have {} operations and numbers, more "
                    "than {}; use fewer or shorter formulas",
                    node_count_, kMaxFormulaNodes));
  return known->second;
}

void ImplicitSurfaceReader::add(const PlacedNode& placed) {
  const JsonView& node = placed.node.view;
  if (extension_of(node.value, kImplicitExtension) == nullptr) return;
  const JsonView extensions{.value = *member(node.value, "extensions"), .kind = "extensions", .parent = &node};
  const JsonView view{.value = *as_object(extensions, kImplicitExtension), .kind = kImplicitExtension, .parent = &node};
  const auto material = as_index(view, "material", count_of(document_, "materials"), "material");
  Shape shape;
  shape.name = placed.node.shown_name();
  shape.kind = ShapeKind::implicit;
  shape.world_from_object = placed.world_from_object;
  shape.formula = formula(view);
  read_bounds(view, shape);
  shape.material = materials_.use(material);
  if (scene_.materials[shape.material].alpha_mode != AlphaMode::opaque)
    notes_.unsupported("opacity of an implicit surface", node.label());
  place_shape(node, std::move(shape), scene_, notes_);
}

}  // namespace eikon
