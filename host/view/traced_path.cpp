// SPDX-License-Identifier: Apache-2.0
#include "view/traced_path.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "render/render.h"
#include "view/scene_outline.h"

namespace eikon {
namespace {

/// A point far along a ray that leaves the scene, nearer if the far one is behind the camera.
glm::dvec3 end_in_front(const Settings& settings, const glm::dvec3& from, const glm::dvec3& along, double radius_m) {
  double distance_m = 4 * radius_m;
  while (distance_m > 1e-3 * radius_m && pixel_of(settings, from + distance_m * along).is_null()) distance_m *= 0.8;
  return from + distance_m * along;
}

}  // namespace

Json traced_path(const Scenery& scenery, const DevicePool& devices, const PixelSample& at) {
  const Settings& settings = scenery.prepared.settings;
  if (at.x >= settings.width || at.y >= settings.height)
    throw UsageError(fmt::format("view: the picture has {} x {} pixels", settings.width, settings.height));
  Json vertices = Json::array();
  const auto add = [&](const glm::dvec3& point, const Json& distance) {
    vertices.push_back(
        {{"point", {point.x, point.y, point.z}}, {"pixel", pixel_of(settings, point)}, {"distance", distance}});
  };
  const double radius_m = radius_of(scenery.bounds);
  const ReadyScene scene{
      .packed = scenery.packed, .features = scenery.features, .devices = devices, .pilot = scenery.pilot};
  const ReplayedSample replayed = replay_path(scene, settings, scenery.execution, at, [&](const PathVertex& v) {
    const glm::dvec3 from = v.origin, along(v.dir);
    if (vertices.empty()) add(from, nullptr);
    if (v.triangle != EK_NO_HIT)
      add(from + double(v.t) * along, v.t);
    else
      add(end_in_front(settings, from, along, radius_m), nullptr);
  });
  glm::vec3 light_paths(0.0F);
  for (const ReplayedSample::Splat& splat : replayed.splats) light_paths += splat.radiance;
  const glm::vec3& r = replayed.radiance;
  return {{"vertices", std::move(vertices)},
          {"radiance", {r.x, r.y, r.z}},
          {"light_paths", {light_paths.x, light_paths.y, light_paths.z}}};
}

}  // namespace eikon
