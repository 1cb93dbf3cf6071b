// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_extensions.h"

#include <array>

#include "gltf/extensions.h"

namespace eikon {
namespace {

std::array<std::span<const MaterialExtensionReader>, 6> groups() {
  return {dielectric_extensions(), specular_glossiness_extensions(),
          layer_extensions(),      microfacet_extensions(),
          measured_extensions(),   emission_extensions()};
}

/// Calls `use` with each row that a material has, and a view of the extension.
template <typename Use>
void for_each_row_of(const JsonView& material, const Use& use) {
  for (const auto group : groups())
    for (const MaterialExtensionReader& row : group)
      if (const Json* json = extension_of(material.value, row.name))
        use(row, JsonView{.value = *json, .kind = row.name, .parent = &material});
}

}  // namespace

const MaterialExtensionReader* find_material_extension(std::string_view name) {
  for (const auto group : groups())
    for (const MaterialExtensionReader& row : group)
      if (name == row.name) return &row;
  return nullptr;
}

void check_material_extensions(const JsonView& material, std::size_t texture_count) {
  for (const JsonMember& extension : members(member(material.value, "extensions"))) {
    const JsonView view{.value = extension.value, .kind = extension.key, .parent = &material};
    if (!is_object(extension.value)) view.fail("is not an object");
    const MaterialExtensionReader* const row = find_material_extension(extension.key);
    if (row != nullptr && row->check != nullptr) row->check(view, texture_count);
  }
}

void read_material_extensions(const JsonView& view, const Factors& factors, Material& material) {
  for_each_row_of(view, [&](const MaterialExtensionReader& row, const JsonView& extension) {
    if (row.read != nullptr) row.read(extension, factors, material);
  });
}

void find_extension_textures(const JsonView& view, TextureReader& textures, Material& material) {
  for_each_row_of(view, [&](const MaterialExtensionReader& row, const JsonView& extension) {
    if (row.find_textures != nullptr) row.find_textures(extension, textures, material);
  });
}

}  // namespace eikon
