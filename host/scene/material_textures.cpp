// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "scene/scene.h"

namespace eikon {

std::vector<TextureUse> textures_of(const Material& m) {
  std::vector<TextureUse> all;
  for (const auto& [texture, name] : {std::pair{&m.base_color_texture, "base colour"},
                                      {&m.metallic_roughness_texture, "metal and roughness"},
                                      {&m.normal_texture, "normal"},
                                      {&m.emissive_texture, "emission"},
                                      {&m.transmission_texture, "transmission"},
                                      {&m.specular_texture, "specular"},
                                      {&m.specular_color_texture, "specular colour"},
                                      {&m.clearcoat_texture, "clearcoat"},
                                      {&m.clearcoat_roughness_texture, "clearcoat roughness"},
                                      {&m.clearcoat_normal_texture, "clearcoat normal"},
                                      {&m.sheen_color_texture, "sheen colour"},
                                      {&m.sheen_roughness_texture, "sheen roughness"},
                                      {&m.diffuse_transmission_texture, "diffuse transmission"},
                                      {&m.diffuse_transmission_color_texture, "diffuse transmission colour"},
                                      {&m.iridescence_texture, "iridescence"},
                                      {&m.film_thickness_texture, "iridescence thickness"},
                                      {&m.anisotropy_texture, "anisotropy"}})
    if (*texture) all.push_back({name, &**texture});
  return all;
}

}  // namespace eikon
