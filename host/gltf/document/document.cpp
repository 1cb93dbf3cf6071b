// SPDX-License-Identifier: Apache-2.0
#include <fstream>  // for tinygltf's writer, which forgets it under TINYGLTF_NO_FS
#define TINYGLTF_IMPLEMENTATION
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document.h"
#include "io/text.h"

namespace eikon {

tinygltf::Model parse_structure(const Json& checked_document) {
  Json reduced = Json::object();
  for (const char* key : {"asset", "scene", "scenes", "nodes", "cameras"}) {
    if (const Json* value = member(checked_document, key)) reduced[key] = *value;
  }
  if (const Json* meshes = member(checked_document, "meshes")) {
    // tinygltf wants the accessor behind the indices; the loader takes that number from the checked document.
    Json& copy = reduced["meshes"] = *meshes;
    for (Json& mesh : copy) {
      for (Json& primitive : mesh["primitives"]) primitive.erase("indices");
    }
  }
  if (member(reduced, "cameras") != nullptr) {
    for (Json& camera : reduced["cameras"]) {
      // Required by glTF, often forgotten, and of no use to a ray tracer.
      if (camera["type"] == "perspective") camera["perspective"].emplace("znear", 1.0);
      if (camera["type"] == "orthographic") {
        camera["orthographic"].emplace("znear", 0.0);
        camera["orthographic"].emplace("zfar", 1.0);
      }
    }
  }
  const std::string text = reduced.dump();
  tinygltf::Model model;
  tinygltf::TinyGLTF parser;
  std::string error, warning;
  if (!parser.LoadASCIIFromString(&model, &error, &warning, text.c_str(), static_cast<unsigned>(text.size()), "",
                                  tinygltf::NO_REQUIRE)) {
    throw InputError("tinygltf refuses the document: " + one_line(error));
  }
  // It skips elements that it cannot read; the numbering would be off.
  const auto same = [&](const char* key, std::size_t count) {
    const Json* array = member(checked_document, key);
    return count == (array == nullptr ? 0 : array->size());
  };
  if (!same("nodes", model.nodes.size()) || !same("meshes", model.meshes.size()) ||
      !same("scenes", model.scenes.size()) || !same("cameras", model.cameras.size())) {
    throw InputError("tinygltf skips a part of the document: " + one_line(error));
  }
  return model;
}

}  // namespace eikon
