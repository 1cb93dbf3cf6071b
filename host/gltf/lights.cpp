// SPDX-License-Identifier: Apache-2.0
#include "gltf/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/error.h"
#include "gltf/light_groups.h"
#include "gltf/geometry/meshes.h"

namespace eikon {
namespace {

constexpr const char* kExtension = "KHR_lights_punctual";
constexpr double kRightAngle = std::numbers::pi / 2;
constexpr double kAngleSlack = 1e-6;  // files keep angles as floats: a float above pi / 2 is still meant as it

double at_least_zero(const Place& place, double value, const char* key, Notes& notes) {
  if (value >= 0) return value;
  notes.warn(fmt::format("{}: {} {:g} clamped to 0", place.label(), key, value));
  return 0;
}

glm::vec3 intensity_of(const Place& place, Notes& notes) {
  const double intensity = at_least_zero(place, as_number(place, "intensity").value_or(1.0), "intensity", notes);
  const Json* colour = member(place.value, "color");
  glm::vec3 result{0.0F};
  for (int c = 0; c < 3; ++c) {
    const double part = colour == nullptr ? 1.0 : (*colour)[static_cast<std::size_t>(c)].get<double>();
    const double value = at_least_zero(place, part, "color", notes) * intensity;
    if (!(value <= static_cast<double>(std::numeric_limits<float>::max())))
      place.refuse(fmt::format("intensity {:g} is beyond single precision; use a smaller one", intensity));
    result[c] = static_cast<float>(value);
  }
  return result;
}

// Half angles; false where nothing is left of the cone. Equal angles are a sharp edge.
bool read_cone(const Place& light_place, PunctualLight& light, Notes& notes) {
  static const Json kDefaults = Json::object();
  const Json* spot = member(light_place.value, "spot");
  const Place place{.value = spot == nullptr ? kDefaults : *spot, .kind = "spot", .parent = &light_place};
  double inner = as_number(place, "innerConeAngle").value_or(0.0);
  double outer = as_number(place, "outerConeAngle").value_or(std::numbers::pi / 4);
  if (!(outer > 0)) {
    notes.warn(fmt::format("{}: left out, its outerConeAngle {:g} lets no light out", light_place.label(), outer));
    return false;
  }
  const auto bring = [&](double& angle, double hi, const char* key) {
    const double legal = std::clamp(angle, 0.0, hi);
    if (std::abs(legal - angle) > kAngleSlack)
      notes.warn(fmt::format("{}: {} {:g} clamped to {:g}", light_place.label(), key, angle, legal));
    angle = legal;
  };
  bring(outer, kRightAngle, "outerConeAngle");
  bring(inner, outer, "innerConeAngle");
  light.inner_cone_rad = inner;
  light.outer_cone_rad = outer;
  return true;
}

}  // namespace

std::int64_t light_of_node(const Json& node) {
  const Json* extensions = member(node, "extensions");
  const Json* found = extensions == nullptr ? nullptr : member(*extensions, kExtension);
  const Json* light = found == nullptr ? nullptr : member(*found, "light");
  return light == nullptr ? -1 : light->get<std::int64_t>();
}

void add_light(const Json& document, std::size_t index, const Place& node, const std::string& node_name,
               const glm::dmat4& world_from_object, Scene& scene, Notes& notes) {
  const Json& json = document["extensions"][kExtension]["lights"][index];
  const Place place{.value = json, .kind = "light", .index = static_cast<std::int64_t>(index)};
  const auto& type = json["type"].get_ref<const std::string&>();
  PunctualLight light;
  light.kind = type == "spot"          ? PunctualLight::Kind::spot
               : type == "directional" ? PunctualLight::Kind::directional
                                       : PunctualLight::Kind::point;
  if (const Json* name = member(json, "name")) light.name = name->get<std::string>();
  if (light.name.empty()) light.name = node_name;
  light.intensity = intensity_of(place, notes);
  light.position = glm::dvec3(world_from_object[3]);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(light.position[axis]) <= kMaxCoordinate))
      place.refuse(fmt::format("lies at {} = {:g}, beyond 2^40 m, the largest coordinate; scale the scene down",
                               "xyz"[axis], light.position[axis]));
  }
  if (light.kind != PunctualLight::Kind::point) {
    const glm::dvec3 back(world_from_object[2]);
    const double largest = std::max({std::abs(back.x), std::abs(back.y), std::abs(back.z)});
    if (!(largest > 0)) return notes.warn(place.label() + ": left out, its node scales its direction to nothing");
    light.direction = -glm::normalize(back / largest);  // by the largest first: squares neither overflow nor vanish
  }
  if (light.kind != PunctualLight::Kind::directional) {
    const double range = as_number(place, "range").value_or(0.0);
    if (member(json, "range") != nullptr && !(range > 0))
      notes.warn(fmt::format("{}: range {:g} is not positive; taken as without end", place.label(), range));
    light.range_m = std::max(range, 0.0);
  }
  if (light.kind == PunctualLight::Kind::spot && !read_cone(place, light, notes)) return;
  light.light_group = light_group_of(node, scene);
  if (light.light_group == 0) light.light_group = light_group_of(place, scene);
  scene.lights.push_back(std::move(light));
}

}  // namespace eikon
