// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/document.h"

#include <fstream>  // for tinygltf's writer, which forgets it under TINYGLTF_NO_FS
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "io/text.h"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace eikon {
namespace {

std::optional<std::size_t> index_of(int number) {
  return number < 0 ? std::nullopt : std::optional(static_cast<std::size_t>(number));
}

// A copy of the members that are asked for. tinygltf would copy extras and extensions to values of
// its own, which take 76 times their text.
Json only(const Json& object, std::initializer_list<const char*> keys) {
  Json result = Json::object();
  for (const char* key : keys)
    if (const Json* value = member(object, key)) result[key] = *value;
  return result;
}

GltfNode read_node(const JsonView& view) {
  tinygltf::Node source;
  std::string error;
  const Json json = only(view.value, {"name", "mesh", "camera", "skin", "children", "matrix", "translation", "rotation",
                                      "scale", "weights"});
  if (!tinygltf::ParseNode(&source, &error, json, false)) view.refuse("tinygltf refuses it: " + one_line(error));
  return {.view = view,
          .name = source.name,
          .mesh = index_of(source.mesh),
          .camera = index_of(source.camera),
          .skin = index_of(source.skin),
          .children = {source.children.begin(), source.children.end()},
          .matrix = source.matrix,
          .translation = source.translation,
          .rotation_xyzw = source.rotation,
          .scale = source.scale,
          .weights = source.weights};
}

GltfMesh read_mesh(const JsonView& view) {
  tinygltf::Mesh source;
  std::string error;
  const Json& primitives = view.value["primitives"];
  Json json = only(view.value, {"name", "weights"});
  for (const Json& primitive : primitives)
    json["primitives"].push_back(only(primitive, {"attributes", "indices", "material", "mode"}));
  // Primitives that tinygltf cannot read are missing afterwards.
  if (!tinygltf::ParseMesh(&source, nullptr, &error, json, false) || source.primitives.size() != primitives.size())
    view.refuse("tinygltf refuses it: " + one_line(error));
  GltfMesh mesh{.view = view, .name = source.name, .primitives = {}, .weights = source.weights};
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const tinygltf::Primitive& primitive = source.primitives[i];
    mesh.primitives.push_back({.json = primitives[i],
                               .attributes = {primitive.attributes.begin(), primitive.attributes.end()},
                               .indices = index_of(primitive.indices),
                               .material = index_of(primitive.material),
                               .mode = primitive.mode});
  }
  return mesh;
}

}  // namespace

Document read_structure(const Json& json, const WrongParts& wrong) {
  Document document{.json = json, .wrong = wrong, .nodes = {}, .meshes = {}, .scene = {}, .scene_nodes = {}};
  const auto view_of = [&](const Json& list, std::string_view kind, std::size_t i) {
    return JsonView{.value = list[i], .kind = kind, .index = static_cast<std::int64_t>(i)};
  };
  const Json &nodes = items(json, "nodes"), &meshes = items(json, "meshes"), &scenes = items(json, "scenes");
  document.nodes.reserve(nodes.size());
  document.meshes.reserve(meshes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) document.nodes.push_back(read_node(view_of(nodes, "node", i)));
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const JsonView view = view_of(meshes, "mesh", i);
    document.meshes.push_back(wrong.has("mesh", i) ? GltfMesh{.view = view, .name = {}, .primitives = {}, .weights = {}}
                                                   : read_mesh(view));
  }
  if (scenes.empty()) return document;
  const Json* const chosen = member(json, "scene");
  document.scene.emplace(view_of(scenes, "scene", chosen == nullptr ? 0 : chosen->get<std::size_t>()));
  if (const Json* const listed = member(document.scene->value, "nodes"))
    document.scene_nodes = listed->get<std::vector<std::size_t>>();
  return document;
}

}  // namespace eikon
