// SPDX-License-Identifier: Apache-2.0
// Ranks that decide which of several overlapping solids counts.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// The rank of each material among the solids that are shown, as nested_media.h uses it: 1 is the
/// lowest, and 0 means that the material is no solid. Ranks follow mediumPriority, which is 0 by
/// default; of equal priorities the later in the file is higher. throws InputError when there are
/// more than EK_MEDIA_RANKS solids
[[nodiscard]] std::vector<std::uint32_t> medium_ranks(const Scene& scene);

}  // namespace eikon
