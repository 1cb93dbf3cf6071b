// SPDX-License-Identifier: Apache-2.0
#include "job/framing.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/scene_memory.h"

namespace eikon {
namespace {

constexpr int kPoses = 9;

/// The bounds of poses of the animations that are in force.
std::vector<Bounds> bounds_of_poses(const SceneOptions& options, const Scene& scene, double begin_s, double end_s) {
  std::vector<Bounds> bounds;
  SceneChoice choice = options.choice();
  choice.animation.loop = false;
  for (int i = 0; i < kPoses; ++i) {
    choice.animation.time_s = begin_s + (end_s - begin_s) * i / (kPoses - 1);
    const Scene pose = load_scene(scene.path, choice, MissingTangents::mark, scene.memory);
    if (const Bounds box = world_bounds(pose); !box.empty()) bounds.push_back(box);
  }
  return bounds;
}

}  // namespace

Camera framing_camera(const SceneOptions& options, const Scene& scene, double aspect) {
  double begin_s = 0, end_s = 0;
  std::string which;
  for (const AnimationSummary& animation : scene.animations) {
    if (!animation.in_force) continue;
    begin_s = which.empty() ? animation.begin_s : std::min(begin_s, animation.begin_s);
    end_s = which.empty() ? animation.end_s : std::max(end_s, animation.end_s);
    which += fmt::format("{} ", &animation - scene.animations.data());
  }
  if (which.empty() || scene.memory == nullptr) return frame_camera(scene, aspect);
  if (!scene.memory->poses(which)) scene.memory->keep_poses(which, bounds_of_poses(options, scene, begin_s, end_s));
  return frame_boxes(*scene.memory->poses(which), aspect);
}

}  // namespace eikon
