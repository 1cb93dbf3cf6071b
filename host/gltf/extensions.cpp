// SPDX-License-Identifier: Apache-2.0
#include "gltf/extensions.h"

#include <fmt/format.h>

#include <algorithm>

#include "gltf/animation/properties.h"
#include "gltf/cameras.h"
#include "gltf/geometry/implicit_surfaces.h"
#include "gltf/geometry/shapes.h"
#include "gltf/materials/material_extensions.h"
#include "gltf/materials/variants.h"
#include "io/text.h"

namespace eikon {
namespace {

using enum ExtensionOwner;

struct Extension {
  std::string_view name;
  ExtensionOwner owners[2];
};
// Extensions of materials have a table of their own, materials/material_extensions.cpp.
constexpr Extension kExtensions[] = {
    {"KHR_lights_punctual", {document, node}},
    {"KHR_mesh_quantization", {none}},
    {kPointerExtension, {none}},
    {"KHR_texture_transform", {texture_info}},
    {"KHR_texture_basisu", {texture}},
    {"EXT_texture_webp", {texture}},
    {"KHR_draco_mesh_compression", {primitive}},
    {"EXT_meshopt_compression", {buffer_view}},
    {"KHR_meshopt_compression", {buffer_view}},
    {kVisibilityExtension, {node}},
    {"EXT_mesh_gpu_instancing", {node}},
    {kVariantsExtension, {document, primitive}},
    {kShapeListExtension, {document}},
    {kShapeExtension, {node}},
    {kImplicitExtension, {node}},
    {kLensExtension, {camera}},
    {kPanoramaExtension, {camera}},
};

// Extensions that a file may require and that a tool can take out of it.
struct Remedy {
  std::string_view extension, what_to_do;
};
constexpr Remedy kRemedies[] = {
    {"EXT_texture_avif", "convert its textures to PNG with `avifdec` or `gltf-transform png`"},
    {"MSFT_texture_dds", "convert its textures to PNG with `magick`"},
};

const Extension* find(std::string_view name) {
  const auto* found = std::ranges::find(kExtensions, name, &Extension::name);
  return found == std::end(kExtensions) ? nullptr : found;
}

bool is_read(std::string_view name, ExtensionOwner kind) {
  if (kind == material) return find_material_extension(name) != nullptr;
  const Extension* const extension = find(name);
  return extension != nullptr && (extension->owners[0] == kind || extension->owners[1] == kind);
}

}  // namespace

const Json* extension_of(const Json& owner, const char* name) { return member(member(owner, "extensions"), name); }

void check_required_extensions(const Json& document) {
  const JsonView root{.value = document, .kind = "document"};
  as_object(root, "extensions");
  for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
    const Json* names = as_array(root, key);
    for (std::size_t i = 0; names != nullptr && i < size_of(*names); ++i)
      if (!is_string(element(*names, i))) root.fail(fmt::format("'{}' holds something that is not a string", key));
  }
  const Json* required = member(document, "extensionsRequired");
  for (std::size_t i = 0; required != nullptr && i < size_of(*required); ++i) {
    const std::string& name = to_string(element(*required, i));
    if (find(name) != nullptr || find_material_extension(name) != nullptr) continue;
    const auto* remedy = std::ranges::find(kRemedies, name, &Remedy::extension);
    root.refuse(fmt::format("requires the extension {}, which this version of eikon does not have; {}", in_quotes(name),
                            remedy == std::end(kRemedies) ? "export without it" : remedy->what_to_do));
  }
}

void note_unsupported_extensions(const Json& owner, ExtensionOwner kind, const std::string& user, Notes& notes) {
  for (const JsonMember& extension : members(member(owner, "extensions")))
    if (!is_read(extension.key, kind)) notes.unsupported(one_line(extension.key), user);
}

}  // namespace eikon
