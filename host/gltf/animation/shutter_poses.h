// SPDX-License-Identifier: Apache-2.0
// The poses that a scene takes while the shutter is open, so that what moves can be blurred.
#pragma once
#include <functional>
#include <memory>

#include "scene/scene.h"

namespace eikon {

/// Loads the scene as it is at a time, with the materials and the visibility of the frame's own
/// time.
using PoseLoader = std::function<Scene(double time_s)>;

inline constexpr std::uint32_t kMaxShutterSteps = 64;

/// Two poses of the same triangles, and the true one between them.
struct MidPose {
  const Scene& before;
  const Scene& after;
  const Scene& true_pose;
  double share = 0;  // of the time between the two that has passed at true_pose
};

/// Returns how far the true pose is from one that goes straight between the two, in units of what
/// is allowed (see the constants in shutter_poses.cpp).
[[nodiscard]] double deviation(const MidPose& step);

/// Adds the poses at the ends of equal steps of the shutter's time to a scene, if anything moves
/// meanwhile. Without a number of steps there are so many that straight ways between poses are near
/// enough to the true ones. throws InputError as the loader
void add_shutter_poses(Scene& scene, const Shutter& shutter, const PoseLoader& pose_at);

/// Adds the pose of the next frame to a scene, unless nothing moves until then.
void add_next_pose(Scene& scene, Scene next);

}  // namespace eikon
