// SPDX-License-Identifier: Apache-2.0
// The camera of a file that has none.
#pragma once
#include "job/prepare.h"

namespace eikon {

/// A camera in front of the scene, as frame_camera has it. Where animations are in force it frames nine
/// poses from their beginning to their end, whatever the time is, so that it stands still in a sequence.
/// throws InputError as load_scene
[[nodiscard]] Camera framing_camera(const SceneOptions& options, const Scene& scene, double aspect);

}  // namespace eikon
