// SPDX-License-Identifier: Apache-2.0
#include "job/framing.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/framing.h"
#include "scene/scene_memory.h"

namespace eikon {
namespace {

constexpr int kPoses = 9;

/// Frames poses of the animations that are in force.
Camera frame_poses(const SceneOptions& options, const Scene& scene, double begin_s, double end_s, double aspect) {
  Framing framing(aspect);
  SceneChoice choice = options.choice();
  choice.animation.loop = false;
  for (int i = 0; i < kPoses; ++i) {
    choice.animation.time_s = begin_s + (end_s - begin_s) * i / (kPoses - 1);
    framing.add(load_scene(scene.path, choice, MissingTangents::mark, scene.memory));
  }
  return framing.camera();
}

}  // namespace

Camera framing_camera(const SceneOptions& options, const Scene& scene, double aspect) {
  std::optional<double> begin_s, end_s;
  std::string which = fmt::format("{:a} {}", aspect, options.variant);
  for (const AnimationSummary& animation : scene.animations) {
    if (!animation.in_force) continue;
    begin_s = std::min(begin_s.value_or(animation.begin_s), animation.begin_s);
    end_s = std::max(end_s.value_or(animation.end_s), animation.end_s);
    which += fmt::format(" {}", &animation - scene.animations.data());
  }
  if (!begin_s || scene.memory == nullptr) return frame_camera(scene, aspect);
  if (const std::optional<Camera> known = scene.memory->camera(which)) return *known;
  const Camera camera = frame_poses(options, scene, *begin_s, *end_s, aspect);
  scene.memory->keep_camera(which, camera);
  return camera;
}

}  // namespace eikon
