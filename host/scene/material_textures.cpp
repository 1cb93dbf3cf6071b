// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string_view>

#include "scene/scene.h"

namespace eikon {

std::vector<TextureUse> textures_of(const Material& m) {
  std::vector<TextureUse> all;
  const auto add = [&](std::string name, const std::optional<Texture>& texture) {
    if (!texture) return;
    name.resize(name.size() - std::string_view("_texture").size());
    std::ranges::replace(name, '_', ' ');
    all.push_back({std::move(name), &*texture});
  };
#define EK_TEXTURE(name, feature) add(#name, m.name);
#define EK_NORMAL_TEXTURE(name, scale) add(#name, m.name);
#include "shared/records.def"
  return all;
}

}  // namespace eikon
