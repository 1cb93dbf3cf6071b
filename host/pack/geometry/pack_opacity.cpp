// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "pack/pack_parts.h"

namespace eikon {
namespace {

bool has_alpha(const TextureImage& image) {
  return std::any_of(image.rgba8.begin(), image.rgba8.end(), [](std::uint32_t texel) { return texel >> 24 != 255; });
}

}  // namespace

PassableMaterials::PassableMaterials(const Scene& scene) {
  std::vector<int> known(scene.images.size(), -1);  // has_alpha; -1: not known yet
  for (const Material& m : scene.materials) {
    if (m.alpha_mode == AlphaMode::opaque) {
      by_material_.push_back(Passable::never);
      continue;
    }
    const bool by_factor = m.opacity < (m.alpha_mode == AlphaMode::mask ? m.alpha_cutoff : 1.0F);
    bool by_texture = false;
    if (!by_factor && m.base_color_texture) {
      int& answer = known.at(m.base_color_texture->image);
      if (answer < 0) answer = has_alpha(scene.images.at(m.base_color_texture->image)) ? 1 : 0;
      by_texture = answer != 0;
    }
    by_material_.push_back(by_factor || by_texture ? Passable::always : Passable::if_colors);
  }
}

bool PassableMaterials::has(const Primitive& primitive) const {
  const Passable passable = by_material_.at(primitive.material);
  if (passable != Passable::if_colors) return passable == Passable::always;
  return std::any_of(primitive.colors.begin(), primitive.colors.end(), [](const glm::vec4& c) { return c.w != 1.0F; });
}

}  // namespace eikon
