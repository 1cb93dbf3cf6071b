// SPDX-License-Identifier: Apache-2.0
// One row for each kind of light says its name and units, and which scenes have such lights. Lights
// without extent are packed here too, because each kind has its own way.
#pragma once

#include "pack/features.h"
#include "pack/lights/light_tree.h"

namespace eikon {

struct LightKindInfo {
  LightKind kind;
  const char* name;
  bool distant;          // infinitely far away: such a light has no place in the light tree
  bool surface;          // triangles or a shape, which Light::triangle names
  bool met;              // rays can meet it, so paths find it by chance, too
  const char* strength;  // what PackedLight::strength is of such a light,
  const char* unit;      // and its unit
  Need (*need)(const Scene& scene, const Settings& settings);  // of kernels that know this kind
};
[[nodiscard]] const LightKindInfo& light_kind(LightKind kind);
/// True if one of the kinds of light that kernels know has a property.
[[nodiscard]] bool has_light(const Features& features, bool (*has_property)(const LightKindInfo&));

/// A light without extent, as kernels, the choice among lights and the light tree need it.
struct PackedPunctualLight {
  Light record{};  // p0, p1 and p2 as kernels/lights/light.h reads them for this kind
  double flux = 0;  // W; 0: it lights nothing
  LightMoments moments{};
};
/// intensity  mean of the channels
/// section_m2  of the sphere around the scene
[[nodiscard]] PackedPunctualLight pack_punctual(const PunctualLight& light, double intensity, double section_m2);

}  // namespace eikon
