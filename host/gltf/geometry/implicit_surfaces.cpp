// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/implicit_surfaces.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/geometry/meshes.h"
#include "gltf/geometry/shapes.h"

namespace eikon {
namespace {

constexpr double kLeastExtent = 0x1p-20;  // of the largest coordinate: floats would tell a few places apart

void read_bounds(const Place& place, Shape& shape) {
  if (!has_numbers(place, "bounds", 6))
    place.refuse("'bounds' is missing; six numbers say where to look: the least x, y, z, then the largest");
  const Json& bounds = place.value["bounds"];
  double lo[3], hi[3], reach = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lo[axis] = bounds[axis].get<double>(), hi[axis] = bounds[3 + axis].get<double>();
    for (const double value : {lo[axis], hi[axis]})
      if (!(std::abs(value) <= kMaxCoordinate))
        place.refuse(fmt::format("'bounds' reach {} = {:g}; at most 2^40 either way", "xyz"[axis], value));
    reach = std::max({reach, std::abs(lo[axis]), std::abs(hi[axis])});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(hi[axis] > lo[axis]))
      place.refuse(
          fmt::format("'bounds' are empty: {} from {:g} to {:g}; first come the least x, y, z, then the largest",
                      "xyz"[axis], lo[axis], hi[axis]));
    if (!(hi[axis] - lo[axis] >= kLeastExtent * reach))
      place.refuse(fmt::format("'bounds' from {:g} to {:g} in {} are too thin for single precision; move or widen them",
                               lo[axis], hi[axis], "xyz"[axis]));
    shape.middle[int(axis)] = 0.5 * (lo[axis] + hi[axis]);
    shape.size[axis] = 0.5 * (hi[axis] - lo[axis]);
  }
}

}  // namespace

bool ImplicitSurfaceReader::has(const Json& node) {
  const Json* const extensions = member(node, "extensions");
  return extensions != nullptr && member(*extensions, kImplicitExtension) != nullptr;
}

std::uint32_t ImplicitSurfaceReader::formula(const Place& place) {
  check_string(place, "f");
  const Json* const f = member(place.value, "f");
  if (f == nullptr) place.refuse("'f' is missing; a formula of x, y and z, as in \"x^2 + y^2 + z^2 - 1\"");
  const std::string& text = f->get_ref<const std::string&>();
  const auto [known, is_new] = known_.try_emplace(text, std::uint32_t(scene_.formulas.size()));
  if (is_new) {
    try {
      scene_.formulas.push_back(formula::parse_formula(text));
    } catch (const InputError& error) {
      place.refuse(fmt::format("f: {}", error.what()));
    }
  }
  return known->second;
}

void ImplicitSurfaceReader::add(const Place& node, const std::string& name, const glm::dmat4& world_from_object) {
  const Place extensions{.value = node.value["extensions"], .kind = "extensions", .parent = &node};
  const Place place{.value = *as_object(extensions, kImplicitExtension), .kind = kImplicitExtension, .parent = &node};
  const auto material = as_index(place, "material", items(document_, "materials").size(), "material");
  Shape shape;
  shape.name = name;
  shape.kind = ShapeKind::implicit;
  shape.world_from_object = world_from_object;
  shape.formula = formula(place);
  read_bounds(place, shape);
  shape.material = use_material_(material ? static_cast<int>(*material) : -1);
  if (scene_.materials[shape.material].alpha_mode != AlphaMode::opaque)
    notes_.unsupported("opacity of an implicit surface", node.label());
  place_shape(node, std::move(shape), scene_, notes_);
}

}  // namespace eikon
