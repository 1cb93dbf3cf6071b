// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/document_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/geometry/attributes.h"
#include "gltf/geometry/instances.h"
#include "gltf/materials/material_layers.h"
#include "gltf/materials/material_measured.h"
#include "gltf/materials/material_microfacets.h"
#include "gltf/materials/material_translucence.h"
#include "io/text.h"
#include "gltf/materials/variants.h"

namespace eikon {
namespace {

constexpr std::uint64_t kAnyInteger = ~std::uint64_t{0};
constexpr double kPi = 3.14159265358979;  // rounded down: the tangent of half of it is large but finite
constexpr std::string_view kSupportedExtensions[] = {
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_iridescence",
    "KHR_materials_anisotropy",
    "EIKON_materials_conductor",
    "EIKON_materials_phong",
    "EIKON_materials_measured",
    "KHR_materials_dispersion",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_variants",
    "KHR_implicit_shapes",
    "EIKON_shape",
    "EIKON_implicit_surface",
    "EIKON_camera_lens",
    "EIKON_camera_panorama",
};
// Extensions that a file may require and that a tool can take out of it.
struct Remedy {
  std::string_view extension, what_to_do;
};
constexpr Remedy kRemedies[] = {
    {"KHR_texture_basisu", "convert its textures to PNG with `ktx extract` or `gltf-transform`"},
    {"EXT_texture_webp", "convert its textures to PNG with `dwebp` or `gltf-transform png`"},
    {"EXT_texture_avif", "convert its textures to PNG with `avifdec` or `gltf-transform png`"},
    {"KHR_materials_pbrSpecularGlossiness", "convert its materials with `gltf-transform metalrough`"},
};

// Calls `check` with each element of the document's array `key`; each must be an object.
template <typename Check>
void for_each(const Json& document, const char* key, std::string_view kind, Check check) {
  const Json& array = items(document, key);
  for (std::size_t i = 0; i < array.size(); ++i) {
    const Place place{.value = array[i], .kind = kind, .index = static_cast<std::int64_t>(i)};
    if (!array[i].is_object()) place.fail("is not an object");
    check_string(place, "name");
    as_object(place, "extensions");
    check(place);
  }
}

// Calls `check` with each element of the array `key` of an object inside the document.
template <typename Check>
void for_each_part(const Place& parent, const char* key, std::string_view kind, Check check) {
  const Json* array = as_array(parent, key);
  if (array == nullptr) return;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const Place place{.value = (*array)[i], .kind = kind, .index = static_cast<std::int64_t>(i), .parent = &parent};
    if (!place.value.is_object()) place.fail("is not an object");
    check(place);
  }
}

// Array of indices, e.g. the children of a node.
void check_indices(const Place& place, const char* key, std::size_t count, std::string_view target) {
  const Json* array = as_array(place, key);
  if (array == nullptr) return;
  for (const Json& element : *array) {
    if (!element.is_number_unsigned() || element.get<std::uint64_t>() >= count) {
      place.fail(fmt::format("'{}' holds {}, which is not one of the {} {}s", key,
                             one_line(element.dump(-1, ' ', true).substr(0, 40)), count, target));
    }
  }
}

// Object whose members are all indices, e.g. the attributes of a primitive.
void check_index_map(const Place& place, std::size_t count, std::string_view target) {
  for (const auto& entry : place.value.items()) {
    const Json& index = entry.value();
    if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= count) {
      place.fail(fmt::format("{} is not one of the {} {}s", in_quotes(entry.key()), count, target));
    }
  }
}

void check_asset(const Json& document) {
  const Place root{.value = document, .kind = "document"};
  const Json* asset = as_object(root, "asset");
  if (asset == nullptr) root.refuse("'asset' with the glTF version is missing; is this a glTF file?");
  const Place place{.value = *asset, .kind = "asset"};
  check_string(place, "version");
  check_string(place, "minVersion");
  const Json* version = member(*asset, "version");
  if (version == nullptr) place.fail("'version' is missing");
  const auto& text = version->get_ref<const std::string&>();
  if (!text.starts_with("2."))
    place.refuse("glTF version " + in_quotes(text) + " is not 2.x; convert the file to glTF 2.0");
  const Json* minimum = member(*asset, "minVersion");
  if (minimum != nullptr && minimum->get_ref<const std::string&>() != "2.0") {
    place.refuse("needs glTF " + in_quotes(minimum->get_ref<const std::string&>()) + "; eikon reads 2.0");
  }
}

void check_extensions_required(const Json& document) {
  const Place root{.value = document, .kind = "document"};
  as_object(root, "extensions");
  for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
    const Json* names = as_array(root, key);
    if (names == nullptr) continue;
    for (const Json& name : *names) {
      if (!name.is_string()) root.fail(fmt::format("'{}' holds something that is not a string", key));
    }
  }
  const Json* required = member(document, "extensionsRequired");
  if (required == nullptr) return;
  for (const Json& name : *required) {
    const auto& text = name.get_ref<const std::string&>();
    if (std::find(std::begin(kSupportedExtensions), std::end(kSupportedExtensions), text) !=
        std::end(kSupportedExtensions))
      continue;
    const auto* remedy =
        std::find_if(std::begin(kRemedies), std::end(kRemedies), [&](const Remedy& r) { return r.extension == text; });
    root.refuse(fmt::format("requires the extension {}, which this version of eikon does not have; {}", in_quotes(text),
                            remedy == std::end(kRemedies) ? "export without it" : remedy->what_to_do));
  }
}

// throws InputError; returns the number of lights
std::size_t check_lights(const Json& document) {
  const Json* extensions = member(document, "extensions");
  if (extensions == nullptr) return 0;
  const Place place{.value = *extensions, .kind = "extensions"};
  const Json* punctual = as_object(place, "KHR_lights_punctual");
  if (punctual == nullptr) return 0;
  const Place owner{.value = *punctual, .kind = "KHR_lights_punctual"};
  for_each_part(owner, "lights", "light", [](const Place& light) {
    check_string(light, "name");
    check_string(light, "type");
    const Json* type = member(light.value, "type");
    if (type == nullptr || (*type != "point" && *type != "spot" && *type != "directional"))
      light.fail("'type' is none of 'point', 'spot', 'directional'");
    has_numbers(light, "color", 3);
    as_number(light, "intensity");
    as_number(light, "range");
    if (const Json* spot = as_object(light, "spot")) {
      const Place cone{.value = *spot, .kind = "spot", .parent = &light};
      as_number(cone, "innerConeAngle");
      as_number(cone, "outerConeAngle");
    }
  });
  const Json* lights = as_array(owner, "lights");
  return lights == nullptr ? 0 : lights->size();
}

void check_nodes(const Json& document) {
  const std::size_t light_count = check_lights(document);
  const std::size_t node_count = items(document, "nodes").size(), mesh_count = items(document, "meshes").size(),
                    camera_count = items(document, "cameras").size(), skin_count = items(document, "skins").size(),
                    accessor_count = items(document, "accessors").size();
  for_each(document, "nodes", "node", [&](const Place& node) {
    as_index(node, "mesh", mesh_count, "mesh");
    as_index(node, "camera", camera_count, "camera");
    as_index(node, "skin", skin_count, "skin");
    check_indices(node, "children", node_count, "node");
    has_numbers(node, "matrix", 16);
    has_numbers(node, "translation", 3);
    has_numbers(node, "rotation", 4);
    has_numbers(node, "scale", 3);
    if (const Json* extensions = member(node.value, "extensions")) {
      const Place place{.value = *extensions, .kind = "extensions", .parent = &node};
      const Json* light = as_object(place, "KHR_lights_punctual");
      if (light != nullptr)
        as_index({.value = *light, .kind = "KHR_lights_punctual", .parent = &node}, "light", light_count, "light");
    }
    check_instancing(node, accessor_count);
  });
  for_each(document, "scenes", "scene", [&](const Place& scene) { check_indices(scene, "nodes", node_count, "node"); });
  as_index({.value = document, .kind = "document"}, "scene", items(document, "scenes").size(), "scene");
}

void check_meshes(const Json& document) {
  const std::size_t accessor_count = items(document, "accessors").size(),
                    material_count = items(document, "materials").size();
  check_variants(document);
  const std::size_t variant_count = variants_of(document).size();
  for_each(document, "meshes", "mesh", [&](const Place& mesh) {
    if (as_array(mesh, "primitives") == nullptr) mesh.fail("'primitives' is missing");
    for_each_part(mesh, "primitives", "primitive", [&](const Place& primitive) {
      const Json* attributes = as_object(primitive, "attributes");
      if (attributes == nullptr) primitive.fail("'attributes' is missing");
      check_index_map({.value = *attributes, .kind = "attributes", .parent = &primitive}, accessor_count, "accessor");
      as_index(primitive, "indices", accessor_count, "accessor");
      as_index(primitive, "material", material_count, "material");
      as_integer(primitive, "mode", 6);
      as_object(primitive, "extensions");
      check_variant_mappings(primitive, material_count, variant_count);
      for_each_part(primitive, "targets", "target",
                    [&](const Place& target) { check_index_map(target, accessor_count, "accessor"); });
    });
  });
}

void check_material_extension(const Place& extension, std::size_t texture_count) {
  if (!extension.value.is_object()) extension.fail("is not an object");
  if (check_layers(extension, texture_count) || check_microfacets(extension, texture_count) ||
      check_translucence(extension, texture_count) || check_measured(extension))
    return;
  if (extension.kind == "KHR_materials_specular") {
    as_number(extension, "specularFactor");
    has_numbers(extension, "specularColorFactor", 3);
    check_texture_slot(extension, "specularTexture", texture_count);
    check_texture_slot(extension, "specularColorTexture", texture_count);
  } else if (extension.kind == "KHR_materials_emissive_strength") {
    as_number(extension, "emissiveStrength");
  } else if (extension.kind == "KHR_materials_ior") {
    as_number(extension, "ior");
  } else if (extension.kind == "KHR_materials_dispersion") {
    as_number(extension, "dispersion");
  } else if (extension.kind == "KHR_materials_transmission") {
    as_number(extension, "transmissionFactor");
    check_texture_slot(extension, "transmissionTexture", texture_count);
  } else if (extension.kind == "KHR_materials_volume") {
    as_number(extension, "thicknessFactor");
    check_texture_slot(extension, "thicknessTexture", texture_count);
    as_number(extension, "attenuationDistance");
    has_numbers(extension, "attenuationColor", 3);
  }
}

void check_materials(const Json& document) {
  const std::size_t texture_count = items(document, "textures").size();
  for_each(document, "materials", "material", [&](const Place& material) {
    if (const Json* factors = as_object(material, "pbrMetallicRoughness")) {
      const Place pbr{.value = *factors, .kind = "pbrMetallicRoughness", .parent = &material};
      has_numbers(pbr, "baseColorFactor", 4);
      as_number(pbr, "metallicFactor");
      as_number(pbr, "roughnessFactor");
      check_texture_slot(pbr, "baseColorTexture", texture_count);
      check_texture_slot(pbr, "metallicRoughnessTexture", texture_count);
    }
    for (const char* slot : {"normalTexture", "occlusionTexture", "emissiveTexture"}) {
      check_texture_slot(material, slot, texture_count);
    }
    has_numbers(material, "emissiveFactor", 3);
    check_string(material, "alphaMode");
    as_number(material, "alphaCutoff");
    if (const Json* sided = member(material.value, "doubleSided"); sided != nullptr && !sided->is_boolean()) {
      material.fail("'doubleSided' is neither true nor false");
    }
    const Json* extensions = member(material.value, "extensions");
    if (extensions == nullptr) return;
    for (const auto& entry : extensions->items()) {
      check_material_extension({.value = entry.value(), .kind = entry.key(), .parent = &material}, texture_count);
    }
  });
}

void check_textures(const Json& document) {
  const std::size_t image_count = items(document, "images").size(), sampler_count = items(document, "samplers").size(),
                    view_count = items(document, "bufferViews").size();
  for_each(document, "textures", "texture", [&](const Place& texture) {
    as_index(texture, "source", image_count, "image");
    as_index(texture, "sampler", sampler_count, "sampler");
    const Json* extensions = member(texture.value, "extensions");
    if (extensions == nullptr) return;
    for (const auto& entry : extensions->items()) {
      const Place extension{.value = entry.value(), .kind = entry.key(), .parent = &texture};
      if (!entry.value().is_object()) extension.fail("is not an object");
    }
  });
  for_each(document, "images", "image", [&](const Place& image) {
    as_index(image, "bufferView", view_count, "bufferView");
    check_string(image, "uri");
  });
  const auto one_of = [](const Place& sampler, const char* key, std::initializer_list<std::uint64_t> legal) {
    const auto value = as_integer(sampler, key, kAnyInteger);
    if (value && std::find(legal.begin(), legal.end(), *value) == legal.end())
      sampler.fail(fmt::format("'{}' {} is none of {}", key, *value, fmt::join(legal, ", ")));
  };
  for_each(document, "samplers", "sampler", [&](const Place& sampler) {
    one_of(sampler, "wrapS", {33071, 33648, 10497});
    one_of(sampler, "wrapT", {33071, 33648, 10497});
    one_of(sampler, "magFilter", {9728, 9729});
  });
}

void check_cameras(const Json& document) {
  for_each(document, "cameras", "camera", [&](const Place& camera) {
    check_string(camera, "type");
    const Json* type = member(camera.value, "type");
    if (type == nullptr || (*type != "perspective" && *type != "orthographic")) {
      camera.fail("'type' is neither 'perspective' nor 'orthographic'");
    }
    const bool perspective = *type == "perspective";
    const char* key = perspective ? "perspective" : "orthographic";
    const Json* lens = as_object(camera, key);
    if (lens == nullptr) camera.fail(fmt::format("'{}' is missing", key));
    const Place place{.value = *lens, .kind = key, .parent = &camera};
    for (const char* number : {"znear", "zfar"}) as_number(place, number);
    if (!perspective) {
      double size[2] = {};
      for (const int axis : {0, 1}) {
        const char* number = axis == 0 ? "xmag" : "ymag";
        size[axis] = std::abs(as_number(place, number).value_or(0));
        if (!(size[axis] > 0 && size[axis] <= kMaxCoordinate)) {
          place.refuse(fmt::format("'{}' is missing, 0 or beyond 2^40 m; it is half the size of the picture", number));
        }
      }
      const double aspect = size[0] / size[1];
      if (!(aspect >= 1e-6 && aspect <= 1e6)) place.refuse(fmt::format("its picture of aspect {:g} is a line", aspect));
      return;
    }
    const double yfov = as_number(place, "yfov").value_or(0), aspect = as_number(place, "aspectRatio").value_or(1);
    if (!(yfov > 0 && yfov < kPi)) place.fail("'yfov' is missing or not between 0 and pi radians");
    if (!(aspect > 0)) place.refuse(fmt::format("'aspectRatio' {:g} is not positive; leave it out for any", aspect));
  });
}

// Skins and animations are left out of the scene; their indices are checked all the same, so that a broken file is
// called broken today and not when they come in.
void check_skins_and_animations(const Json& document) {
  const std::size_t node_count = items(document, "nodes").size(), accessor_count = items(document, "accessors").size();
  for_each(document, "skins", "skin", [&](const Place& skin) {
    check_indices(skin, "joints", node_count, "node");
    as_index(skin, "skeleton", node_count, "node");
    as_index(skin, "inverseBindMatrices", accessor_count, "accessor");
  });
  for_each(document, "animations", "animation", [&](const Place& animation) {
    const Json* samplers = as_array(animation, "samplers");
    for_each_part(animation, "samplers", "sampler", [&](const Place& sampler) {
      as_index(sampler, "input", accessor_count, "accessor");
      as_index(sampler, "output", accessor_count, "accessor");
    });
    for_each_part(animation, "channels", "channel", [&](const Place& channel) {
      as_index(channel, "sampler", samplers == nullptr ? 0 : samplers->size(), "sampler");
      if (const Json* target = as_object(channel, "target")) {
        as_index({.value = *target, .kind = "target", .parent = &channel}, "node", node_count, "node");
      }
    });
  });
}

void check_storage(const Json& document) {
  const std::size_t buffer_count = items(document, "buffers").size(),
                    view_count = items(document, "bufferViews").size();
  for_each(document, "buffers", "buffer", [](const Place& buffer) {
    check_string(buffer, "uri");
    required_integer(buffer, "byteLength", kAnyInteger);
  });
  for_each(document, "bufferViews", "bufferView", [&](const Place& view) {
    if (!as_index(view, "buffer", buffer_count, "buffer")) view.fail("'buffer' is missing");
  });
  for_each(document, "accessors", "accessor", [&](const Place& accessor) {
    as_index(accessor, "bufferView", view_count, "bufferView");
    check_string(accessor, "type");
  });
}

}  // namespace

void check_texture_slot(const Place& owner, const char* key, std::size_t texture_count) {
  const Json* info = as_object(owner, key);
  if (info == nullptr) return;
  const Place place{.value = *info, .kind = key, .parent = &owner};
  if (!as_index(place, "index", texture_count, "texture")) place.fail("'index' is missing");
  as_integer(place, "texCoord", kAnyInteger);
  as_number(place, "scale");
  const Json* extensions = as_object(place, "extensions");
  if (extensions == nullptr) return;
  const Place all{.value = *extensions, .kind = "extensions", .parent = &place};
  if (const Json* found = as_object(all, "KHR_texture_transform")) {
    const Place transform{.value = *found, .kind = "KHR_texture_transform", .parent = &place};
    has_numbers(transform, "offset", 2);
    as_number(transform, "rotation");
    has_numbers(transform, "scale", 2);
    as_integer(transform, "texCoord", kAnyInteger);
  }
}

const Json& items(const Json& document, const char* key) {
  static const Json kNone = Json::array();
  const Json* array = as_array({.value = document, .kind = "document"}, key);
  return array == nullptr ? kNone : *array;
}

void check_document(const Json& document) {
  check_asset(document);
  check_extensions_required(document);
  check_storage(document);
  check_meshes(document);
  check_textures(document);
  check_materials(document);
  check_cameras(document);
  check_skins_and_animations(document);
  check_nodes(document);
}

}  // namespace eikon
