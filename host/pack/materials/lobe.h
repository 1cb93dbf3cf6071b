// SPDX-License-Identifier: Apache-2.0
// The lobe that each material scatters by.
#pragma once
#include <cstdint>

#include "scene/scene.h"

namespace eikon {

/// The lobes of kernels/shared/features.def. The value is the bit of MaterialRecord.flags that
/// names the lobe to kernels.
enum class Lobe : std::uint32_t {
#define EK_LOBE(name, bit) name = bit,
#include "shared/features.def"
};

/// The lobe that scatters as this material does. A material has one, and coat and sheen lie over
/// it.
[[nodiscard]] Lobe lobe_of(const Material& material);

/// True if the material's surfaces are the boundary of something that light goes into.
[[nodiscard]] bool is_solid(const Material& material);

}  // namespace eikon
