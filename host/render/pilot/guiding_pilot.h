// SPDX-License-Identifier: Apache-2.0
// The part of a pilot that learns where light comes from, and weighs whether paths should be guided by it.
#pragma once
#include <cstdint>

#include "render/pilot/pilot_picture.h"

namespace eikon {

/// The settings of the picture from which it learns.
[[nodiscard]] Settings guiding_picture_settings(const Settings& settings);
/// The most paths that it renders at once.
[[nodiscard]] std::uint64_t largest_guiding_round(const Settings& settings);

/// picture   of a program with feature path_log
/// settings  of the image. throws DeviceError
[[nodiscard]] Pilot run_guiding_pilot(PilotPicture& picture, const Settings& settings);

}  // namespace eikon
