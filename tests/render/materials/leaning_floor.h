// SPDX-License-Identifier: Apache-2.0
// A floor whose normal map leans the same way everywhere.
#pragma once
#include "render/scene_builder.h"

namespace eikon::test {

/// A normal map that leans the same way everywhere. tilt_deg: of its normal, towards u
inline Texture add_leaning_map(Scene& scene, double tilt_deg) {
  const auto byte = [](double x) { return static_cast<std::uint32_t>(std::lround(127.5 + 127.5 * x)); };
  const double tilt = tilt_deg * kPi / 180;
  TextureImage image;
  image.name = "leaning";
  image.width = image.height = 1;
  image.rgba8 = {byte(std::sin(tilt)) | byte(0) << 8 | byte(std::cos(tilt)) << 16 | 0xff000000U};
  scene.images.push_back(image);
  Texture texture;
  texture.image = static_cast<std::uint32_t>(scene.images.size() - 1);
  return texture;
}

/// A square of the plane y = 0 under a camera at this angle with its normal, on the side of +x. u
/// grows along x.
inline std::pair<Scene, Settings> floor_of(const Material& material, double view_deg, std::uint64_t spp) {
  Scene scene;
  Primitive floor;
  add_quad(floor, {-10, 0, 10}, {20, 0, 0}, {0, 0, -20});
  floor.uv[0].assign(floor.positions_object.size(), glm::vec2(0));
  floor.tangents_object.assign(floor.positions_object.size(), {1, 0, 0, 1});
  add_mesh(scene, "floor", std::move(floor), material);
  Settings settings = settings_for(4, 4, spp);
  const double view = view_deg * kPi / 180;
  settings.camera = look_at_camera({std::sin(view), std::cos(view), 0}, {0, 0, 0}, {0, 0, 1}, 0.001);
  settings.environment.radiance = glm::vec3(0);
  return {std::move(scene), settings};
}

}  // namespace eikon::test
