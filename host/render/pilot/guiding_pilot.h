// SPDX-License-Identifier: Apache-2.0
// The part of a pilot that learns where light comes from, and weighs whether paths should be guided
// by it.
#pragma once
#include <cstdint>

#include "render/pilot/pilot_picture.h"

namespace eikon {

/// The settings of the picture from which it learns.
[[nodiscard]] Settings guiding_picture_settings(const Settings& settings);
/// The most paths that it renders at once.
[[nodiscard]] std::uint64_t largest_guiding_round(const Settings& settings);

/// picture   of a program with feature path_log
/// settings  of the image
/// pilot     gets the table, if paths are to be guided, and the figures of its report about that.
///           throws DeviceError
void run_guiding_pilot(PilotPicture& picture, const Settings& settings, Pilot& pilot);

}  // namespace eikon
