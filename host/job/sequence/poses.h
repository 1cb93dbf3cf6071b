// SPDX-License-Identifier: Apache-2.0
// What is decided for all times of an animation together, so that it stays the same in a sequence.
#pragma once
#include <functional>

#include "job/prepare.h"

namespace eikon {

/// A camera in front of the scene, as frame_camera has it. Where animations are in force it frames
/// nine poses from their beginning to their end, whatever the time is.
/// throws InputError as load_scene
[[nodiscard]] Camera framing_camera(const SceneOptions& options, const Scene& scene, double aspect);

/// True if the scene has light of its own at one of these nine times, though it may be dark at its
/// own. throws InputError as load_scene
[[nodiscard]] bool is_lit_at_some_time(const SceneOptions& options, const Scene& scene);

/// The most light of these nine times, or less if it is `enough`; that of the scene as it stands
/// where no animation is in force. `light_of` depends on the pose, on `aspect` and on how `options`
/// choose the camera. throws InputError as load_scene
[[nodiscard]] double most_light(const SceneOptions& options, const Scene& scene, double aspect, double enough,
                                const std::function<double(const Scene&)>& light_of);

}  // namespace eikon
