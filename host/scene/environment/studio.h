// SPDX-License-Identifier: Apache-2.0
// The neutral environment: light for scenes that bring none.
#pragma once
#include <memory>

#include "scene/scene.h"

namespace eikon {

/// A photographer's studio without colour, as an environment map: a floor, walls and a ceiling that
/// grow brighter upwards, and three large soft lights (a key light in front on the left of +Z, a
/// fill light on the right, a rim light behind), so that white, metal and glass show their shapes.
/// All of it is smooth, and white paper that faces the brightest side has a radiance of 1.
[[nodiscard]] std::shared_ptr<const EnvironmentMap> neutral_studio();

}  // namespace eikon
