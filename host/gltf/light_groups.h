// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "io/json_text.h"
#include "scene/scene.h"

namespace eikon {

/// Number of the group that `place` names by extras.lightGroup: that of Scene::light_groups, added to them if it is new; 0, "rest",
/// where it names none.
/// throws InputError: no string, a name of other characters than letters, digits, - and _, longer than 64, or one group too many
std::uint32_t light_group_of(const Place& place, Scene& scene);

}  // namespace eikon
