// SPDX-License-Identifier: Apache-2.0
// Areas of shapes as their nodes place them, for lights.
#pragma once
#include <array>

#include "scene/shape.h"

namespace eikon {

/// Areas in the world of the parts of a shape, m^2: of a cylinder its side, bottom and top, of a capsule its side, lower and
/// upper cap; of others the whole comes first. 0 where a part does not exist. To a part in 10^6 (implicit surfaces: 0, they are no lights to sample).
[[nodiscard]] std::array<double, 3> part_areas_m2(ShapeKind kind, const OwnShape& own);

}  // namespace eikon
