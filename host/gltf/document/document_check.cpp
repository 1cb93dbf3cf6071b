// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/document_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>  // wrong elements are replaced
#include <set>

#include "core/error.h"
#include "gltf/cameras.h"
#include "gltf/extensions.h"
#include "gltf/geometry/instances.h"
#include "gltf/lights.h"
#include "gltf/materials/material_extensions.h"
#include "gltf/materials/variants.h"
#include "io/text.h"
#include "scene/limits.h"

namespace eikon {
namespace {

constexpr std::uint64_t kAnyInteger = ~std::uint64_t{0};
constexpr double kPi = 3.14159265358979;  // rounded down: the tangent of half of it is large but finite

template <typename Check>
void check_element(const JsonView& view, Check check) {
  if (!is_object(view.value)) view.fail("is not an object");
  as_string(view, "name");
  as_object(view, "extensions");
  check(view);
}

// Calls `check` with each element of the document's array `key`; each must be an object.
template <typename Check>
void for_each(const Json& document, const char* key, std::string_view kind, Check check) {
  const Json& array = items(document, key);
  for (std::size_t i = 0; i < size_of(array); ++i) {
    check_element({.value = element(array, i), .kind = kind, .index = static_cast<std::int64_t>(i)}, check);
  }
}

// As for_each; an element that fails is added to `wrong` and becomes what `remains` makes of it.
template <typename Check, typename Remains>
void for_each_usable(Json& document, const char* key, std::string_view kind, WrongParts& wrong, Check check,
                     Remains remains) {
  const std::size_t count = count_of(document, key);
  for (std::size_t i = 0; i < count; ++i) {
    const JsonView view{.value = document[key][i], .kind = kind, .index = static_cast<std::int64_t>(i)};
    try {
      check_element(view, check);
    } catch (const InputError& e) {
      wrong.add(view, e.what());
      document[key][i] = remains(view.value);
    }
  }
}

// As above; an element that fails becomes an empty object.
template <typename Check>
void for_each_usable(Json& document, const char* key, std::string_view kind, WrongParts& wrong, Check check) {
  for_each_usable(document, key, kind, wrong, check, [](const Json&) { return Json::object(); });
}

// Calls `check` with each element of the array `key` of an object inside the document.
template <typename Check>
void for_each_part(const JsonView& parent, const char* key, std::string_view kind, Check check) {
  const Json* array = as_array(parent, key);
  if (array == nullptr) return;
  for (std::size_t i = 0; i < size_of(*array); ++i) {
    const JsonView view{
        .value = element(*array, i), .kind = kind, .index = static_cast<std::int64_t>(i), .parent = &parent};
    if (!is_object(view.value)) view.fail("is not an object");
    check(view);
  }
}

// Checks an array of indices, e.g. the children of a node.
void check_indices(const JsonView& view, const char* key, std::size_t count, std::string_view target) {
  const Json* array = as_array(view, key);
  for (std::size_t i = 0; array != nullptr && i < size_of(*array); ++i) {
    const Json& index = element(*array, i);
    if (!is_index(index, count))
      view.fail(fmt::format("'{}' holds {}, which is not one of the {} {}s", key, excerpt(index), count, target));
  }
}

// Checks an object whose members are all indices, e.g. the attributes of a primitive.
void check_index_map(const JsonView& view, std::size_t count, std::string_view target) {
  for (const JsonMember& entry : members(&view.value))
    if (!is_index(entry.value, count))
      view.fail(fmt::format("{} is not one of the {} {}s", in_quotes(entry.key), count, target));
}

// The weights of morph targets; how many there have to be is asked where they are used.
void has_weights(const JsonView& view) {
  if (const Json* weights = as_array(view, "weights")) has_numbers(view, "weights", size_of(*weights));
}

void check_asset(const Json& document) {
  const JsonView root{.value = document, .kind = "document"};
  const Json* asset = as_object(root, "asset");
  if (asset == nullptr) root.refuse("'asset' with the glTF version is missing; is this a glTF file?");
  const JsonView view{.value = *asset, .kind = "asset"};
  const std::string *version = as_string(view, "version"), *minimum = as_string(view, "minVersion");
  if (version == nullptr) view.fail("'version' is missing");
  if (!version->starts_with("2."))
    view.refuse("glTF version " + in_quotes(*version) + " is not 2.x; convert the file to glTF 2.0");
  if (minimum != nullptr && *minimum != "2.0") view.refuse("needs glTF " + in_quotes(*minimum) + "; eikon reads 2.0");
}

// throws InputError; returns the number of lights
std::size_t check_lights(const Json& document) {
  const Json* extensions = member(document, "extensions");
  if (extensions == nullptr) return 0;
  const JsonView view{.value = *extensions, .kind = "extensions"};
  const Json* punctual = as_object(view, "KHR_lights_punctual");
  if (punctual == nullptr) return 0;
  const JsonView owner{.value = *punctual, .kind = "KHR_lights_punctual"};
  for_each_part(owner, "lights", "light", check_light);
  const Json* lights = as_array(owner, "lights");
  return lights == nullptr ? 0 : size_of(*lights);
}

// The children of a wrong node stay below it, so that whoever needs one of them, as skins may,
// finds what is wrong.
Json children_alone(const Json& node, std::size_t node_count) {
  const Json* const children = member(node, "children");
  std::set<std::size_t> legal;
  for (std::size_t i = 0; children != nullptr && is_array(*children) && i < size_of(*children); ++i)
    if (is_index(element(*children, i), node_count)) legal.insert(to_index(element(*children, i)));
  Json kept = Json::object();
  if (!legal.empty()) kept["children"] = legal;
  return kept;
}

void check_nodes(Json& document, WrongParts& wrong) {
  const std::size_t light_count = check_lights(document);
  const std::size_t node_count = count_of(document, "nodes"), mesh_count = count_of(document, "meshes"),
                    camera_count = count_of(document, "cameras"), skin_count = count_of(document, "skins"),
                    accessor_count = count_of(document, "accessors");
  const auto remains = [&](const Json& node) { return children_alone(node, node_count); };
  const auto check = [&](const JsonView& node) {
    as_index(node, "mesh", mesh_count, "mesh");
    as_index(node, "camera", camera_count, "camera");
    as_index(node, "skin", skin_count, "skin");
    check_indices(node, "children", node_count, "node");
    has_numbers(node, "matrix", 16);
    has_numbers(node, "translation", 3);
    has_numbers(node, "rotation", 4);
    has_numbers(node, "scale", 3);
    has_weights(node);
    if (const Json* extensions = member(node.value, "extensions")) {
      const JsonView view{.value = *extensions, .kind = "extensions", .parent = &node};
      const Json* light = as_object(view, "KHR_lights_punctual");
      if (light != nullptr)
        as_index({.value = *light, .kind = "KHR_lights_punctual", .parent = &node}, "light", light_count, "light");
      if (const Json* visibility = as_object(view, kVisibilityExtension)) {
        const Json* visible = member(*visibility, "visible");
        if (visible != nullptr && !is_boolean(*visible)) node.fail("'visible' is neither true nor false");
      }
    }
    check_instancing(node, accessor_count);
  };
  for_each_usable(document, "nodes", "node", wrong, check, remains);
  for_each(document, "scenes", "scene",
           [&](const JsonView& scene) { check_indices(scene, "nodes", node_count, "node"); });
  as_index({.value = document, .kind = "document"}, "scene", count_of(document, "scenes"), "scene");
}

void check_meshes(Json& document, WrongParts& wrong) {
  const std::size_t accessor_count = count_of(document, "accessors"), material_count = count_of(document, "materials");
  check_variants(document);
  const std::size_t variant_count = variants_of(document).size();
  for_each_usable(document, "meshes", "mesh", wrong, [&](const JsonView& mesh) {
    has_weights(mesh);
    if (as_array(mesh, "primitives") == nullptr) mesh.fail("'primitives' is missing");
    for_each_part(mesh, "primitives", "primitive", [&](const JsonView& primitive) {
      const Json* attributes = as_object(primitive, "attributes");
      if (attributes == nullptr) primitive.fail("'attributes' is missing");
      check_index_map({.value = *attributes, .kind = "attributes", .parent = &primitive}, accessor_count, "accessor");
      as_index(primitive, "indices", accessor_count, "accessor");
      as_index(primitive, "material", material_count, "material");
      as_integer(primitive, "mode", 6);
      as_object(primitive, "extensions");
      check_variant_mappings(primitive, material_count, variant_count);
      for_each_part(primitive, "targets", "target",
                    [&](const JsonView& target) { check_index_map(target, accessor_count, "accessor"); });
    });
  });
}

void check_materials(Json& document, WrongParts& wrong) {
  const std::size_t texture_count = count_of(document, "textures");
  for_each_usable(document, "materials", "material", wrong, [&](const JsonView& material) {
    if (const Json* factors = as_object(material, "pbrMetallicRoughness")) {
      const JsonView pbr{.value = *factors, .kind = "pbrMetallicRoughness", .parent = &material};
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
    as_string(material, "alphaMode");
    as_number(material, "alphaCutoff");
    if (const Json* sided = member(material.value, "doubleSided"); sided != nullptr && !is_boolean(*sided)) {
      material.fail("'doubleSided' is neither true nor false");
    }
    check_material_extensions(material, texture_count);
  });
}

void check_textures(Json& document, WrongParts& wrong) {
  const std::size_t image_count = count_of(document, "images"), sampler_count = count_of(document, "samplers"),
                    view_count = count_of(document, "bufferViews");
  for_each_usable(document, "textures", "texture", wrong, [&](const JsonView& texture) {
    as_index(texture, "source", image_count, "image");
    as_index(texture, "sampler", sampler_count, "sampler");
    for (const JsonMember& entry : members(member(texture.value, "extensions"))) {
      const JsonView extension{.value = entry.value, .kind = entry.key, .parent = &texture};
      if (!is_object(entry.value)) extension.fail("is not an object");
    }
  });
  for_each_usable(document, "images", "image", wrong, [&](const JsonView& image) {
    as_index(image, "bufferView", view_count, "bufferView");
    as_string(image, "uri");
  });
  const auto one_of = [](const JsonView& sampler, const char* key, std::initializer_list<std::uint64_t> legal) {
    const auto value = as_integer(sampler, key, kAnyInteger);
    if (value && std::find(legal.begin(), legal.end(), *value) == legal.end())
      sampler.fail(fmt::format("'{}' {} is none of {}", key, *value, fmt::join(legal, ", ")));
  };
  for_each_usable(document, "samplers", "sampler", wrong, [&](const JsonView& sampler) {
    one_of(sampler, "wrapS", {33071, 33648, 10497});
    one_of(sampler, "wrapT", {33071, 33648, 10497});
    one_of(sampler, "magFilter", {9728, 9729});
  });
}

void check_perspective(const JsonView& view) {
  const double yfov = as_number(view, "yfov").value_or(0), aspect = as_number(view, "aspectRatio").value_or(1);
  if (!(yfov > 0 && yfov < kPi)) view.fail("'yfov' is missing or not between 0 and pi radians");
  if (!(aspect >= kMinAspect && aspect <= kMaxAspect))
    view.refuse(fmt::format("'aspectRatio' {:g} is not from {:g} to {:g}; leave it out for any", aspect, kMinAspect,
                            kMaxAspect));
}

void check_orthographic(const JsonView& view) {
  for (const char* number : {"xmag", "ymag"}) {
    const double size = std::abs(as_number(view, number).value_or(0));
    if (!(size > 0 && size <= kMaxCoordinate))
      view.refuse(fmt::format("'{}' is missing, 0 or beyond 2^40 m; it is half the size of the picture", number));
  }
  orthographic_aspect(view);
}

void check_cameras(Json& document, WrongParts& wrong) {
  for_each_usable(document, "cameras", "camera", wrong, [&](const JsonView& camera) {
    const std::string* type = as_string(camera, "type");
    if (type == nullptr || (*type != "perspective" && *type != "orthographic"))
      camera.fail("'type' is neither 'perspective' nor 'orthographic'");
    const Json* lens = as_object(camera, type->c_str());
    if (lens == nullptr) camera.fail(fmt::format("'{}' is missing", *type));
    const JsonView view{.value = *lens, .kind = *type, .parent = &camera};
    for (const char* number : {"znear", "zfar"}) as_number(view, number);
    if (*type == "perspective")
      check_perspective(view);
    else
      check_orthographic(view);
  });
}

// The keys of animations and the matrices of skins are checked where they are read.
void check_skins_and_animations(Json& document, WrongParts& wrong) {
  const std::size_t node_count = count_of(document, "nodes"), accessor_count = count_of(document, "accessors");
  for_each_usable(document, "skins", "skin", wrong, [&](const JsonView& skin) {
    check_indices(skin, "joints", node_count, "node");
    as_index(skin, "skeleton", node_count, "node");
    as_index(skin, "inverseBindMatrices", accessor_count, "accessor");
  });
  for_each_usable(document, "animations", "animation", wrong, [&](const JsonView& animation) {
    const Json* samplers = as_array(animation, "samplers");
    for_each_part(animation, "samplers", "sampler", [&](const JsonView& sampler) {
      as_index(sampler, "input", accessor_count, "accessor");
      as_index(sampler, "output", accessor_count, "accessor");
    });
    for_each_part(animation, "channels", "channel", [&](const JsonView& channel) {
      as_index(channel, "sampler", samplers == nullptr ? 0 : size_of(*samplers), "sampler");
      if (const Json* target = as_object(channel, "target")) {
        as_index({.value = *target, .kind = "target", .parent = &channel}, "node", node_count, "node");
      }
    });
  });
}

void check_storage(Json& document, WrongParts& wrong) {
  const std::size_t buffer_count = count_of(document, "buffers"), view_count = count_of(document, "bufferViews");
  for_each(document, "buffers", "buffer", [](const JsonView& buffer) {
    as_string(buffer, "uri");
    required_integer(buffer, "byteLength", kAnyInteger);
  });
  for_each(document, "bufferViews", "bufferView", [&](const JsonView& view) {
    if (!as_index(view, "buffer", buffer_count, "buffer")) view.fail("'buffer' is missing");
  });
  for_each_usable(document, "accessors", "accessor", wrong, [&](const JsonView& accessor) {
    as_index(accessor, "bufferView", view_count, "bufferView");
    as_string(accessor, "type");
  });
}

}  // namespace

void check_texture_slot(const JsonView& owner, const char* key, std::size_t texture_count) {
  const Json* info = as_object(owner, key);
  if (info == nullptr) return;
  const JsonView view{.value = *info, .kind = key, .parent = &owner};
  if (!as_index(view, "index", texture_count, "texture")) view.fail("'index' is missing");
  as_integer(view, "texCoord", kAnyInteger);
  as_number(view, "scale");
  const Json* extensions = as_object(view, "extensions");
  if (extensions == nullptr) return;
  const JsonView all{.value = *extensions, .kind = "extensions", .parent = &view};
  if (const Json* found = as_object(all, "KHR_texture_transform")) {
    const JsonView transform{.value = *found, .kind = "KHR_texture_transform", .parent = &view};
    has_numbers(transform, "offset", 2);
    as_number(transform, "rotation");
    has_numbers(transform, "scale", 2);
    as_integer(transform, "texCoord", kAnyInteger);
  }
}

const Json& items(const Json& document, const char* key) {
  const Json* array = as_array({.value = document, .kind = "document"}, key);
  return array == nullptr ? empty_array() : *array;
}

std::size_t count_of(const Json& document, const char* key) { return size_of(items(document, key)); }

void check_document(Json& document, WrongParts& wrong) {
  check_asset(document);
  check_required_extensions(document);
  check_storage(document, wrong);
  check_meshes(document, wrong);
  check_textures(document, wrong);
  check_materials(document, wrong);
  check_cameras(document, wrong);
  check_skins_and_animations(document, wrong);
  check_nodes(document, wrong);
}

}  // namespace eikon
