// SPDX-License-Identifier: Apache-2.0
// One row for each kind of light: what is said of such lights, and which scenes have them.
#pragma once
#include <cstdint>

#include "pack/features.h"

namespace eikon {

/// The kinds of kernels/shared/features.def, with the values that Light.kind has in kernels.
enum class LightKind : std::uint32_t {
#define EK_LIGHT(name, bit) name = bit,
#include "shared/features.def"
};

struct LightKindInfo {
  LightKind kind;
  const char* name;
  bool distant;          // infinitely far away: such a light has no place in the light tree
  const char* strength;  // what PackedLight::strength is of such a light,
  const char* unit;      // and its unit
  Need (*need)(const Scene& scene, const Settings& settings);  // of kernels that know this kind
};
[[nodiscard]] const LightKindInfo& light_kind(LightKind kind);

[[nodiscard]] LightKind kind_of(const PunctualLight& light);

}  // namespace eikon
