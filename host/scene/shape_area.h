// SPDX-License-Identifier: Apache-2.0
// The areas of shapes in the world, for lights.
#pragma once
#include <array>

#include "scene/shape.h"

namespace eikon {

/// The areas of a shape's parts in the world, in m^2, to a part in 10^6: of a cylinder its side,
/// bottom and top; of a capsule its side, lower and upper cap; of others the whole and zeros.
/// Implicit surfaces have 0, because they are not sampled as lights.
[[nodiscard]] std::array<double, 3> part_areas_m2(ShapeKind kind, const OwnShape& own);

}  // namespace eikon
