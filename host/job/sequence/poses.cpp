// SPDX-License-Identifier: Apache-2.0
#include "job/sequence/poses.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/scene_memory.h"
#include "scene/view/framing.h"

namespace eikon {
namespace {

constexpr int kPoses = 9;

/// Times from the first key to the last one of the animations in force; empty if none is.
std::vector<double> times_of(const Scene& scene) {
  std::optional<double> begin_s, end_s;
  for (const AnimationSummary& animation : scene.animations) {
    if (!animation.in_force) continue;
    begin_s = std::min(begin_s.value_or(animation.begin_s), animation.begin_s);
    end_s = std::max(end_s.value_or(animation.end_s), animation.end_s);
  }
  std::vector<double> times;
  for (int i = 0; begin_s && i < kPoses; ++i) times.push_back(*begin_s + (*end_s - *begin_s) * i / (kPoses - 1));
  return times;
}

Scene pose_at(double time_s, const SceneOptions& options, const Scene& scene) {
  SceneChoice choice = options.choice();
  choice.animation.loop = false;
  choice.animation.shutter = {};
  choice.animation.next_s.reset();
  choice.animation.time_s = time_s;
  return load_scene(scene.path, choice, MissingTangents::mark, scene.memory);
}

}  // namespace

Camera framing_camera(const SceneOptions& options, const Scene& scene, double aspect) {
  const std::vector<double> times = times_of(scene);
  if (times.empty() || scene.memory == nullptr) return frame_camera(scene, aspect);
  std::string which = fmt::format("{:a} {}", aspect, options.variant);
  for (const AnimationSummary& animation : scene.animations) which += animation.in_force ? '+' : '-';
  if (const std::optional<Camera> known = scene.memory->camera(which)) return *known;
  Framing framing(aspect);
  for (const double time_s : times) framing.add(pose_at(time_s, options, scene));
  scene.memory->keep_camera(which, framing.camera());
  return framing.camera();
}

bool is_lit_at_some_time(const SceneOptions& options, const Scene& scene) {
  if (!needs_environment(scene)) return true;
  const auto changes = [](const AnimationSummary& animation) { return animation.in_force && animation.changes_light; };
  if (std::ranges::none_of(scene.animations, changes)) return false;
  return std::ranges::any_of(times_of(scene),
                             [&](double time_s) { return !needs_environment(pose_at(time_s, options, scene)); });
}

}  // namespace eikon
