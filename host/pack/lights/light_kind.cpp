// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_kind.h"

#include <algorithm>
#include <fmt/format.h>

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
  const auto found = std::ranges::find(scene.lights, kind, kind_of);
  if (found == scene.lights.end()) return {false, "no such light"};
  return {true, fmt::format("light '{}'", found->name)};
}

constexpr LightKindInfo kKinds[] = {
    // kind, name, distant, strength and its unit, need
    {LightKind::area, "area", false, kRadiance, kRadianceUnit, emissive_material},
    {LightKind::environment, "environment", true, kRadiance, kRadianceUnit, constant_environment},
    {LightKind::environment_map, "environment_map", true, kRadiance, kRadianceUnit, environment_map},
    {LightKind::point, "point", false, kIntensity, kIntensityUnit, punctual<LightKind::point>},
    {LightKind::spot, "spot", false, kIntensity, kIntensityUnit, punctual<LightKind::spot>},
    {LightKind::directional, "directional", true, "irradiance", "W/m^2 (lx)", punctual<LightKind::directional>},
    {LightKind::shape_light, "shape_light", false, kRadiance, kRadianceUnit, emissive_shape},
};

}  // namespace

const LightKindInfo& light_kind(LightKind kind) {
  const auto found = std::ranges::find(kKinds, kind, &LightKindInfo::kind);
  if (found == std::end(kKinds)) throw InternalError("a kind of light without a row");
  return *found;
}

LightKind kind_of(const PunctualLight& light) {
  switch (light.kind) {
    case PunctualLight::Kind::point:
      return LightKind::point;
    case PunctualLight::Kind::spot:
      return LightKind::spot;
    case PunctualLight::Kind::directional:
      return LightKind::directional;
  }
  throw InternalError("a punctual light of no kind");
}

}  // namespace eikon
