// SPDX-License-Identifier: Apache-2.0
// Skins: the matrices that joints have where the nodes of the scene stand.
#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/document/document.h"
#include "gltf/document/node_graph.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// A skin at the pose of the scene. The vertices of a mesh with it are in the world's coordinates,
/// whatever the transform of its node [glTF 2.0, section 3.7.3.3].
struct Skin {
  std::string label;               // "skin 'arm'"
  std::vector<glm::dmat4> joints;  // world_from_mesh of each: finite, affine
};

/// The skin that counts for the mesh of a node; nothing if it has none, or if none of the mesh's
/// primitives has joints, so that it stands as if it had none.
[[nodiscard]] std::optional<std::size_t> skin_of(const Document& document, const GltfNode& node);

/// Notes a node whose skin does not count, because its mesh has no joints.
void note_unused_skin(const Document& document, const GltfNode& node, Notes& notes);

/// Lists the skins of a checked document.
[[nodiscard]] std::vector<SkinSummary> list_skins(const Json& document);

/// The most joints of all skins of a scene together.
inline constexpr std::size_t kMaxJoints = std::size_t{1} << 22U;

/// Reads skins at their first use.
class SkinReader {
 public:
  /// The arguments outlive the reader. `placed`: the nodes of `document`, as walk_nodes has them
  SkinReader(const Document& document, const AccessorTable& accessors, const std::vector<PlacedNode>& placed,
             Notes& notes);

  /// throws InputError: a skin that is wrong, without joints, with matrices that are too few or not
  /// finite, more joints than kMaxJoints in all
  const Skin& operator[](std::size_t skin);

 private:
  [[nodiscard]] Skin read(std::size_t index);
  [[nodiscard]] const glm::dmat4& place_of(std::size_t joint, const std::string& user);
  /// The first place of each node, by their numbers; null for those that are not placed.
  [[nodiscard]] std::vector<const PlacedNode*> by_node(const std::vector<PlacedNode>& placed) const;

  const Document& document_;
  const AccessorTable& accessors_;
  Notes& notes_;
  std::vector<const PlacedNode*> placed_;  // by node
  std::optional<OwnPlaces> own_places_;    // once a joint is not in the scene
  std::map<std::size_t, Skin> read_;
  std::size_t joint_count_ = 0;  // of those that are read
};

}  // namespace eikon
