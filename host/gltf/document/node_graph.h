// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "gltf/document/document.h"
#include "io/text.h"

namespace eikon {

/// A node of the scene and its transform with those of all its parents applied.
struct PlacedNode {
  std::size_t node = 0;  // index into the document's nodes
  glm::dmat4 world_from_object{1.0};
};

/// The nodes under the document's scene (the default scene, else the first, else all roots), parents before children,
/// in the order of the file. Iterative: the depth of the graph is the file's choice. throws InputError: NODE_LOOP with
/// the names in the loop, a node with two parents, a scene that lists a child, a rotation of length 0, a matrix with a
/// projective row, a transform that overflows
std::vector<PlacedNode> walk_nodes(const tinygltf::Model& model, Notes& notes);

/// "node 'lamp'"
[[nodiscard]] std::string node_label(const tinygltf::Model& model, std::size_t node);

}  // namespace eikon
