// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/material_traits.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/error.h"
#include "shared/records.h"

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

Lobe lobe_of(const Material& material) {
  if (material.unlit) return Lobe::diffuse;
  if (material.lobe) return *material.lobe;
  const bool may_be_dielectric = material.metallic < 1 || material.metallic_roughness_texture;
  if ((material.transmission > 0 || material.diffuse_transmission > 0) && may_be_dielectric) return Lobe::transmission;
  if (material.metallic > 0 || material.specular > 0 || material.iridescence > 0) return Lobe::metallic_roughness;
  return Lobe::diffuse;
}

bool has_trait(const Material& material, std::uint32_t wanted) {
  std::uint32_t of_lobe = 0;
  switch (lobe_of(material)) {
#define EK_LOBE(name, bit, traits) \
  case Lobe::name:                 \
    of_lobe = traits;              \
    break;
#include "shared/features.def"
  }
  return (of_lobe & wanted) != 0;
}

bool is_solid(const Material& material) { return material.solid && has_trait(material, EK_TRAIT_TRANSMITS); }

bool may_have_openings(const Material& m) {
  if (m.alpha_mode == AlphaMode::opaque || !is_solid(m) || m.transmission == 0) return false;
  // A material that is transparent everywhere bounds nothing.
  const bool is_somewhere = m.alpha_mode == AlphaMode::mask ? m.opacity >= m.alpha_cutoff : m.opacity > 0;
  return is_somewhere && m.emission == glm::vec3(0);
}

bool is_single_sided(const Material& material) {
  return !material.double_sided && !has_trait(material, EK_TRAIT_TRANSMITS);
}

std::uint32_t shading_class(const Material& material, const Primitive* primitive) {
  if (has_trait(material, EK_TRAIT_TRANSMITS)) return SHADING_TRANSMISSIVE;
  const bool bare = material.clearcoat == 0 && material.sheen_color == glm::vec3(0) && textures_of(material).empty();
  const bool flat = primitive == nullptr || (primitive->normals_object.empty() && primitive->tangents_object.empty() &&
                                             primitive->colors.empty());
  return has_trait(material, EK_TRAIT_LAMBERT) && bare && flat ? SHADING_FLAT_LAMBERT : SHADING_OPAQUE;
}

std::uint32_t surface_flags(const Material& material, const Primitive* primitive) {
  return shading_class(material, primitive) << EK_TRIANGLE_CLASS_SHIFT |
         (is_single_sided(material) ? EK_TRIANGLE_SINGLE_SIDED : 0);
}

std::vector<bool> shown_materials(const Scene& scene) {
  std::vector<bool> shown(scene.materials.size());
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) shown[primitive.material] = true;
  for (const Shape& shape : scene.shapes) shown[shape.material] = true;
  return shown;
}

std::vector<std::uint32_t> medium_ranks(const Scene& scene) {
  const std::vector<bool> shown = shown_materials(scene);
  std::vector<std::uint32_t> solids;
  for (std::uint32_t i = 0; i < scene.materials.size(); ++i)
    if (shown[i] && is_solid(scene.materials[i])) solids.push_back(i);
  if (solids.size() > EK_MEDIA_RANKS)
    throw InputError(fmt::format(
        "{}: mediumPriority orders {} solids at most, and materials of {} are shown; let some share one, or "
        "leave the priorities out",
        scene.path.string(), EK_MEDIA_RANKS, solids.size()));
  std::ranges::stable_sort(solids, {}, [&](std::uint32_t i) { return scene.materials[i].medium_priority.value_or(0); });
  std::vector<std::uint32_t> ranks(scene.materials.size());
  for (std::size_t i = 0; i < solids.size(); ++i) ranks[solids[i]] = std::uint32_t(i + 1);
  return ranks;
}

}  // namespace eikon
