// SPDX-License-Identifier: Apache-2.0
#include "view/scene_outline.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace eikon {
namespace {

Json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json camera_json(const Camera& camera) {
  const glm::dmat4& m = camera.world_from_camera;
  const bool perspective = camera.projection == Projection::perspective;
  return {{"name", camera.name},
          {"eye", vector_json(glm::dvec3(m[3]))},
          {"back", vector_json(glm::dvec3(m[2]))},
          {"up", vector_json(glm::dvec3(m[1]))},
          {"fov", perspective ? Json(camera.yfov_rad * 180 / std::numbers::pi) : Json(nullptr)}};
}

/// First and last second of the animations in force.
Json time_json(const Scene& scene) {
  double begin_s = 1e300, end_s = -1e300;
  for (const AnimationSummary& animation : scene.animations) {
    if (!animation.in_force || animation.channel_count == 0) continue;
    begin_s = std::min(begin_s, animation.begin_s);
    end_s = std::max(end_s, animation.end_s);
  }
  return begin_s < end_s ? Json({begin_s, end_s}) : Json(nullptr);
}

std::string environment_name(const Environment& environment) {
  if (environment.map) return std::filesystem::path(environment.map->name).filename().string();
  return environment.radiance == glm::vec3(0.0F) ? "none" : "constant";
}

}  // namespace

double radius_of(const Bounds& bounds) {
  return bounds.empty() ? 1 : std::max(1e-9, 0.5 * glm::length(bounds.hi - bounds.lo));
}

Json scene_outline(const Scene& scene, const Bounds& bounds, const Settings& settings) {
  Json cameras = Json::array();
  for (const Camera& camera : scene.cameras) cameras.push_back(camera_json(camera));
  const glm::dvec3 middle = bounds.empty() ? glm::dvec3(0) : 0.5 * (bounds.lo + bounds.hi);
  return {{"name", scene.path.filename().string()},
          {"cameras", std::move(cameras)},
          {"view", camera_json(settings.camera)},
          {"variants", scene.variants},
          {"time", time_json(scene)},
          {"environment", environment_name(settings.environment)},
          {"lights", scene.light_groups.size() > 1 ? Json(scene.light_groups) : Json::array()},
          {"middle", vector_json(middle)},
          {"radius", radius_of(bounds)}};
}

Json pixel_of(const Settings& settings, const glm::dvec3& point) {
  const Camera& camera = settings.camera;
  if (camera.projection == Projection::panorama) return nullptr;
  const glm::dvec3 p = glm::dvec3(glm::inverse(camera.world_from_camera) * glm::dvec4(point, 1));
  const bool perspective = camera.projection == Projection::perspective;
  if (perspective && !(p.z < 0)) return nullptr;
  // Half the height of the picture at the point's distance.
  const double half = perspective ? -p.z * std::tan(0.5 * camera.yfov_rad) : camera.ymag_m;
  const double scale = 0.5 * settings.height / half;
  return {0.5 * settings.width + p.x * scale, 0.5 * settings.height - p.y * scale};
}

}  // namespace eikon
