// SPDX-License-Identifier: Apache-2.0
#include "render/frame.h"

#include <cmath>

namespace eikon {

Frame pack_frame(const PackedScene& packed, const Settings& settings) {
  Frame frame{};
  const glm::dmat4& m = settings.camera.world_from_camera;
  const glm::dvec3 right = glm::normalize(glm::dvec3(m[0])), up = glm::normalize(glm::dvec3(m[1])),
                   back = glm::normalize(glm::dvec3(m[2]));
  const double half_height = std::tan(0.5 * settings.camera.yfov_rad);
  const double pixel = 2 * half_height / settings.height;  // side of a pixel on the plane at distance 1
  const glm::dvec3 corner = -back + up * half_height - right * (0.5 * pixel * settings.width);
  const auto pack = [](const glm::dvec3& v, double w = 0) {
    return float4{float(v.x), float(v.y), float(v.z), float(w)};
  };
  frame.camera_origin = pack(glm::dvec3(m[3]));
  frame.camera_x = pack(right * pixel);
  frame.camera_y = pack(up * -pixel);
  frame.camera_corner = pack(corner);
  frame.environment = pack(glm::dvec3(settings.environment.radiance), packed.environment_probability);
  if (!packed.bounds.empty()) {
    // Half the extent, seen from the rounded centre, rounded up: the box that they span encloses the scene.
    const glm::vec3 center = glm::vec3(0.5 * (packed.bounds.lo + packed.bounds.hi));
    const glm::dvec3 half = glm::max(packed.bounds.hi - glm::dvec3(center), glm::dvec3(center) - packed.bounds.lo);
    frame.scene_center = pack(center);
    frame.scene_half = pack(half * (1.0 + 0x1p-20));
  }
  frame.seed = settings.seed;
  frame.replicate_bits = settings.replicate_bits;
  frame.max_depth = settings.max_depth;
  frame.roulette_depth = settings.roulette_depth;
  frame.light_count = std::uint32_t(packed.light_buckets.size());
  return frame;
}

}  // namespace eikon
