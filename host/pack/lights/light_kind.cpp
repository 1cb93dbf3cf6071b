// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_kind.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "scene/emission.h"

namespace eikon {
namespace {

constexpr const char *kRadiance = "mean radiance", *kRadianceUnit = "W/(sr m^2)";
constexpr const char *kIntensity = "intensity", *kIntensityUnit = "W/sr (cd)";

Need emissive_material(const Scene& scene, const Settings&) {
  const Material* const emitter = first_emitter(scene);
  if (emitter == nullptr) return {false, "nothing emits"};
  return {true, fmt::format("material '{}'", emitter->name)};
}

Need emissive_shape(const Scene& scene, const Settings&) {
  const auto lamp = std::ranges::find_if(
      scene.shapes, [&](const Shape& each) { return is_sampled_light(each, scene.materials[each.material]); });
  if (lamp == scene.shapes.end()) return {false, "no shape emits"};
  return {true, fmt::format("node '{}'", lamp->name)};
}

Need constant_environment(const Scene&, const Settings& settings) {
  const Environment& environment = settings.environment;
  if (environment.map) return {false, "the environment is a map"};
  if (!shines(environment)) return {false, "the environment is black"};
  return {true, "the environment"};
}

Need environment_map(const Scene&, const Settings& settings) {
  const EnvironmentMap* const map = settings.environment.map.get();
  if (map == nullptr) return {false, "no map"};
  return {true, map->name};
}

template <LightKind kind>
Need punctual(const Scene& scene, const Settings&) {
  const auto found = std::ranges::find(scene.lights, kind, &PunctualLight::kind);
  if (found == scene.lights.end()) return {false, "no such light"};
  return {true, fmt::format("light '{}'", found->name)};
}

constexpr LightKindInfo kKinds[] = {
    // kind, name; distant, surface, met; strength and its unit; need
    {LightKind::area, "area", false, true, true, kRadiance, kRadianceUnit, emissive_material},
    {LightKind::environment, "environment", true, false, true, kRadiance, kRadianceUnit, constant_environment},
    {LightKind::environment_map, "environment_map", true, false, true, kRadiance, kRadianceUnit, environment_map},
    {LightKind::point, "point", false, false, false, kIntensity, kIntensityUnit, punctual<LightKind::point>},
    {LightKind::spot, "spot", false, false, false, kIntensity, kIntensityUnit, punctual<LightKind::spot>},
    {LightKind::directional, "directional", true, false, false, "irradiance", "W/m^2 (lx)",
     punctual<LightKind::directional>},
    {LightKind::shape_light, "shape_light", false, true, true, kRadiance, kRadianceUnit, emissive_shape},
};

}  // namespace

const LightKindInfo& light_kind(LightKind kind) {
  const auto found = std::ranges::find(kKinds, kind, &LightKindInfo::kind);
  if (found == std::end(kKinds)) throw InternalError("a kind of light without a row");
  return *found;
}

bool has_light(const Features& features, bool (*has_property)(const LightKindInfo&)) {
  bool found = false;
#define EK_LIGHT(name, bit) found = found || (features.has(Feature::name) && has_property(light_kind(LightKind::name)));
#include "shared/features.def"
  return found;
}

PackedPunctualLight pack_punctual(const PunctualLight& light, double intensity, double section_m2) {
  PackedPunctualLight packed;
  Light& r = packed.record;
  const glm::vec3 position(light.position), back(-glm::normalize(light.direction));
  r.p0_x = position.x, r.p0_y = position.y, r.p0_z = position.z;
  r.p1_x = back.x, r.p1_y = back.y, r.p1_z = back.z;
  if (light.kind == LightKind::directional) {
    packed.flux = intensity * section_m2;
    return packed;
  }
  packed.moments.centroid = light.position;
  r.p2_z = light.range_m > 0 ? float(light.range_m * light.range_m) : std::numeric_limits<float>::infinity();
  if (light.kind == LightKind::point) {  // a spot whose cone contains every direction
    r.p2_x = -2.0F, r.p2_y = 1.0F;
    packed.flux = intensity * (4 * std::numbers::pi);
    return packed;
  }
  // [KHR_lights_punctual]: the cosine falls from 1 to 0 over max(0.001, cos inner - cos outer).
  const double outer = std::cos(light.outer_cone_rad);
  const double ramp = std::max(0.001, std::cos(light.inner_cone_rad) - outer), top = std::min(1.0, outer + ramp);
  r.p2_x = float(outer), r.p2_y = float(1 / ramp);
  packed.flux = intensity * (2 * std::numbers::pi * ((1 - top) + std::pow(top - outer, 3) / (3 * ramp * ramp)));
  packed.moments.mean_direction = glm::dvec3(-back) * (0.5 + 0.5 * top);
  return packed;
}

}  // namespace eikon
