// SPDX-License-Identifier: Apache-2.0
// A checked document as its reader uses it, and the boundary to tinygltf: no other file includes
// its header.
//
// tinygltf 2.7 reads JSON into structs. It does not check ranges, follows URIs anywhere, hands
// unchecked bytes to image decoders and recurses as deep as the file nests. So it gets neither the
// file nor its buffers, but the tree of JSON that source_file, json_text and document_check have
// been through, and of that what the structs below hold only. Bytes are read through `Accessor`.
#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gltf/document/wrong_parts.h"
#include "io/json_text.h"

namespace eikon {

/// A primitive of a mesh. Its numbers are indices into the document's arrays, all of them legal.
struct GltfPrimitive {
  const Json& json;                               // for extensions and targets of morphing
  std::map<std::string, std::size_t> attributes;  // "POSITION" -> accessor
  std::optional<std::size_t> indices, material;
  int mode = 4;  // 0 to 6; 4: triangles
};

struct GltfMesh {
  JsonView view;  // for messages and extensions
  std::string name;
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;  // of the primitives' targets; empty: none is in force
};

struct GltfNode {
  JsonView view;  // for messages and extensions
  std::string name;
  std::optional<std::size_t> mesh, camera, skin;
  std::vector<std::size_t> children;
  // Its transform is `matrix`, column after column, or else the product of the others. Empty:
  // absent.
  std::vector<double> matrix, translation, rotation_xyzw, scale;
  std::vector<double> weights;  // in place of the mesh's; empty: the mesh's count

  /// Its name, or "node 3".
  [[nodiscard]] std::string shown_name() const { return name.empty() ? view.label() : name; }
};

/// A document of which every index, type and required member has been checked, but for the parts
/// in `wrong`, which are empty here.
struct Document {
  const Json& json;  // all of it
  const WrongParts& wrong;
  std::vector<GltfNode> nodes;
  std::vector<GltfMesh> meshes;
  std::optional<JsonView> scene;         // the default scene, or else the first
  std::vector<std::size_t> scene_nodes;  // that it lists
};

/// Reads the structure of a document that check_document has let pass, which outlives the result.
/// throws InputError with tinygltf's words
Document read_structure(const Json& checked_document, const WrongParts& wrong);

}  // namespace eikon
