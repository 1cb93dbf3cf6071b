// SPDX-License-Identifier: Apache-2.0
// Which of several solids counts where they overlap.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// Of each material its rank among the solids that are shown, as nested_media.h has them: 1 is the lowest, 0 is no solid's. By priority,
/// which is 0 where a material says none; of equal ones the later in the file is higher.
/// throws InputError when they are more than EK_MEDIA_RANKS
[[nodiscard]] std::vector<std::uint32_t> medium_ranks(const Scene& scene);

}  // namespace eikon
