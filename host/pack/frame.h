// SPDX-License-Identifier: Apache-2.0
// What a camera sees, as kernels take it.
#pragma once
#include "pack/pack.h"

namespace eikon {

/// Camera, environment and bounds; the unit's own fields are left 0.
Frame pack_frame(const PackedScene& packed, const Settings& settings);

}  // namespace eikon
