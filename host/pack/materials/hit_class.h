// SPDX-License-Identifier: Apache-2.0
// What shading a surface takes: paths that hit surfaces of one class are shaded together (kernels/stages/hit_classes.h).
#pragma once
#include <cstdint>

#include "scene/scene.h"

namespace eikon {

/// One of SHADING_* (records.h). primitive: null for shapes
[[nodiscard]] std::uint32_t hit_class(const Material& material, const Primitive* primitive);

/// The same as bits of a triangle's flags.
[[nodiscard]] std::uint32_t hit_class_flags(const Material& material, const Primitive* primitive);

}  // namespace eikon
