// SPDX-License-Identifier: Apache-2.0
// Classes of surfaces by the shading that they take. Paths that hit one class are shaded together
// (kernels/stages/hit_classes.h).
#pragma once
#include <cstdint>

#include "scene/scene.h"

namespace eikon {

/// The class SHADING_* (records.h) of a surface. primitive: null for shapes
[[nodiscard]] std::uint32_t hit_class(const Material& material, const Primitive* primitive);

/// The class as bits of a triangle's flags.
[[nodiscard]] std::uint32_t hit_class_flags(const Material& material, const Primitive* primitive);

}  // namespace eikon
