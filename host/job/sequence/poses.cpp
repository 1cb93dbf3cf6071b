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

/// Tells apart which animations are in force: a sign for each.
std::string in_force(const Scene& scene) {
  std::string signs;
  for (const AnimationSummary& animation : scene.animations) signs += animation.in_force ? '+' : '-';
  return signs;
}

/// Tells apart cameras that differ in what they see of a scene.
std::string view_of(const SceneOptions& options, double aspect) {
  std::string text = fmt::format("{:a} {} {} {}", aspect, options.panorama, name_of(options.culling), options.camera);
  if (options.fov_deg) text += fmt::format(" fov {:a}", *options.fov_deg);
  if (options.look_at)
    for (const glm::dvec3& v : {options.look_at->eye, options.look_at->target, options.look_at->up})
      text += fmt::format(" {:a} {:a} {:a}", v.x, v.y, v.z);
  return text;
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
  const std::string which = fmt::format("{:a} {} {}", aspect, options.variant, in_force(scene));
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

double most_light(const SceneOptions& options, const Scene& scene, double aspect, double enough,
                  const std::function<double(const Scene&)>& light_of) {
  const std::vector<double> times = times_of(scene);
  if (times.empty() || scene.memory == nullptr) return light_of(scene);
  const std::string which = fmt::format("{} {} {}", in_force(scene), view_of(options, aspect), options.variant);
  if (const std::optional<double> known = scene.memory->light(which)) return *known;
  double most = 0;
  for (const double time_s : times)
    if (most < enough) most = std::max(most, light_of(pose_at(time_s, options, scene)));
  scene.memory->keep_light(which, most);
  return most;
}

}  // namespace eikon
