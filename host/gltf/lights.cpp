// SPDX-License-Identifier: Apache-2.0
#include "gltf/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "gltf/extensions.h"
#include "gltf/light_groups.h"
#include "scene/limits.h"

namespace eikon {
namespace {

constexpr const char* kExtension = "KHR_lights_punctual";
constexpr double kRightAngle = std::numbers::pi / 2;
constexpr double kAngleSlack = 1e-6;  // files keep angles as floats: a float above pi / 2 is still meant as it

double at_least_zero(const JsonView& view, double value, const char* key, Notes& notes) {
  if (value >= 0) return value;
  notes.warn(fmt::format("{}: {} {:g} clamped to 0", view.label(), key, value));
  return 0;
}

glm::vec3 intensity_of(const JsonView& view, Notes& notes) {
  const double intensity = at_least_zero(view, as_number(view, "intensity").value_or(1.0), "intensity", notes);
  const Json* colour = member(view.value, "color");
  glm::vec3 result{0.0F};
  for (int c = 0; c < 3; ++c) {
    const double part = colour == nullptr ? 1.0 : number_at(*colour, static_cast<std::size_t>(c));
    const double value = at_least_zero(view, part, "color", notes) * intensity;
    if (!(value <= static_cast<double>(std::numeric_limits<float>::max())))
      view.refuse(fmt::format("intensity {:g} is beyond single precision; use a smaller one", intensity));
    result[c] = static_cast<float>(value);
  }
  return result;
}

// Reads the half angles; returns false if nothing is left of the cone. Equal angles are a sharp
// edge.
bool read_cone(const JsonView& light_view, PunctualLight& light, Notes& notes) {
  const Json* spot = member(light_view.value, "spot");
  const JsonView view{.value = spot == nullptr ? empty_object() : *spot, .kind = "spot", .parent = &light_view};
  double inner = as_number(view, "innerConeAngle").value_or(0.0);
  double outer = as_number(view, "outerConeAngle").value_or(std::numbers::pi / 4);
  if (!(outer > 0)) {
    notes.warn(fmt::format("{}: left out, its outerConeAngle {:g} lets no light out", light_view.label(), outer));
    return false;
  }
  const auto bring = [&](double& angle, double hi, const char* key) {
    const double legal = std::clamp(angle, 0.0, hi);
    if (std::abs(legal - angle) > kAngleSlack)
      notes.warn(fmt::format("{}: {} {:g} clamped to {:g}", light_view.label(), key, angle, legal));
    angle = legal;
  };
  bring(outer, kRightAngle, "outerConeAngle");
  bring(inner, outer, "innerConeAngle");
  light.inner_cone_rad = inner;
  light.outer_cone_rad = outer;
  return true;
}

}  // namespace

void check_light(const JsonView& light) {
  as_string(light, "name");
  const std::string* type = as_string(light, "type");
  if (type == nullptr || (*type != "point" && *type != "spot" && *type != "directional"))
    light.fail("'type' is none of 'point', 'spot', 'directional'");
  has_numbers(light, "color", 3);
  as_number(light, "intensity");
  as_number(light, "range");
  if (const Json* spot = as_object(light, "spot")) {
    const JsonView cone{.value = *spot, .kind = "spot", .parent = &light};
    as_number(cone, "innerConeAngle");
    as_number(cone, "outerConeAngle");
  }
}

void add_light(const Json& document, const PlacedNode& placed, Scene& scene, Notes& notes) {
  const Json* const reference = member(extension_of(placed.node.view.value, kExtension), "light");
  if (reference == nullptr) return;
  const std::size_t index = to_index(*reference);
  const Json& json = element(*member(extension_of(document, kExtension), "lights"), index);
  const JsonView view{.value = json, .kind = "light", .index = static_cast<std::int64_t>(index)};
  const Json* const type = member(json, "type");
  PunctualLight light;
  light.kind = equals(type, "spot")          ? LightKind::spot
               : equals(type, "directional") ? LightKind::directional
                                             : LightKind::point;
  if (const Json* name = member(json, "name")) light.name = to_string(*name);
  if (light.name.empty()) light.name = placed.node.name;
  light.intensity = intensity_of(view, notes);
  light.position = glm::dvec3(placed.world_from_object[3]);
  check_position(view, placed);
  if (light.kind != LightKind::point) {
    const glm::dvec3 back(placed.world_from_object[2]);
    const double largest = std::max({std::abs(back.x), std::abs(back.y), std::abs(back.z)});
    if (!(largest > 0)) return notes.warn(view.label() + ": left out, its node scales its direction to nothing");
    light.direction = -glm::normalize(back / largest);  // by the largest first: squares neither overflow nor vanish
  }
  if (light.kind != LightKind::directional) {
    const double range = as_number(view, "range").value_or(0.0);
    if (member(json, "range") != nullptr && !(range > 0))
      notes.warn(fmt::format("{}: range {:g} is not positive; taken as without end", view.label(), range));
    light.range_m = std::max(range, 0.0);
  }
  if (light.kind == LightKind::spot && !read_cone(view, light, notes)) return;
  light.light_group = light_group_of(placed.node.view, scene);
  if (light.light_group == 0) light.light_group = light_group_of(view, scene);
  scene.lights.push_back(std::move(light));
}

}  // namespace eikon
