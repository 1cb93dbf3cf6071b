// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "io/json_text.h"
#include "scene/scene.h"

namespace eikon {

/// The index in `scene.light_groups` of the group that `owner` names by extras.lightGroup; a new
/// name is appended. 0, "rest", if it names none.
/// throws InputError: no string, a name of other characters than letters, digits, - and _, longer
///        than 64, or one group too many
std::uint32_t light_group_of(const JsonView& owner, Scene& scene);

}  // namespace eikon
