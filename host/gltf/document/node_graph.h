// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "gltf/document/document.h"
#include "scene/notes.h"

namespace eikon {

/// A node of the scene, and its transform with those of all its parents applied.
struct PlacedNode {
  const GltfNode& node;
  glm::dmat4 world_from_object{1.0};
  bool visible = true;  // neither the node nor one above it says otherwise (KHR_node_visibility)
};

/// The nodes under the document's scene (or all roots, if it has no scene), parents before
/// children, in the order of the file. A node with several parents stands under each; one that the
/// scene lists besides a node above it stands where its parent puts it. The walk is iterative,
/// because the depth of the graph is the file's choice.
/// throws InputError: NODE_LOOP with the names in the loop, a node listed twice, too many by shared
///        parents, a rotation of length 0, a matrix with a projective row, a transform that
///        overflows, a node that is wrong
std::vector<PlacedNode> walk_nodes(const Document& document, Notes& notes);

/// Tells where nodes stand by their own parents, whatever the document's scene lists. A node with
/// several parents stands where a walk from all roots comes to it first. What is wrong with a node
/// matters to those below it only.
class OwnPlaces {
 public:
  /// The arguments outlive the places; walk_nodes has let the document pass.
  OwnPlaces(const Document& document, Notes& notes);
  /// throws InputError as walk_nodes, of the node and of those above it
  const glm::dmat4& operator[](std::size_t node);

 private:
  const Document& document_;
  Notes& notes_;
  std::vector<std::size_t> parents_;         // on the way by which the walk comes first
  std::map<std::size_t, glm::dmat4> known_;  // world from object
};

/// Checks where the node of a light or a camera stands. throws InputError: a position beyond
/// kMaxCoordinate
void check_position(const JsonView& of, const PlacedNode& placed);

}  // namespace eikon
