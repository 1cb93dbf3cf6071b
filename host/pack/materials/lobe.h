// SPDX-License-Identifier: Apache-2.0
// The lobe that each material scatters by.
#pragma once
#include <cstdint>

#include "scene/scene.h"

namespace eikon {

/// The lobe that scatters as this material does. A material has one, and coat and sheen lie over
/// it.
[[nodiscard]] Lobe lobe_of(const Material& material);

/// True if the material's surfaces are the boundary of something that light goes into.
[[nodiscard]] bool is_solid(const Material& material);

}  // namespace eikon
