// SPDX-License-Identifier: Apache-2.0
#include "gltf/skin/skins.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "scene/transform.h"

namespace eikon {
namespace {

JsonView view_of_skin(const Json& document, std::size_t index) {
  return {.value = element(items(document, "skins"), index), .kind = "skin", .index = static_cast<std::int64_t>(index)};
}

bool has_joints(const GltfMesh& mesh) {
  return std::ranges::any_of(mesh.primitives,
                             [](const GltfPrimitive& primitive) { return primitive.attributes.contains("JOINTS_0"); });
}

/// Checks the accessor of the inverse bind matrices [glTF 2.0, section 3.7.3.1].
const Accessor& check_matrices(const JsonView& view, const Accessor& matrices, std::size_t joint_count) {
  if (matrices.component != ComponentType::f32 || !matrices.is_matrix || matrices.component_count != 16)
    view.fail(fmt::format("inverse bind matrices in {} are not MAT4 of float", matrices.label));
  if (matrices.count < joint_count)
    view.fail(
        fmt::format("has {} joints, but {} inverse bind matrices in {}", joint_count, matrices.count, matrices.label));
  return matrices;
}

}  // namespace

std::optional<std::size_t> skin_of(const Document& document, const GltfNode& node) {
  return node.skin && node.mesh && has_joints(document.meshes[*node.mesh]) ? node.skin : std::nullopt;
}

void note_unused_skin(const Document& document, const GltfNode& node, Notes& notes) {
  if (node.skin && node.mesh && !has_joints(document.meshes[*node.mesh]))
    notes.mended(fmt::format("{}: has a skin, but its {} has no JOINTS_0; it stands where its node puts it",
                             node.view.label(), document.meshes[*node.mesh].view.label()));
}

std::vector<SkinSummary> list_skins(const Json& document) {
  std::vector<SkinSummary> skins;
  const Json& list = items(document, "skins");
  for (std::size_t i = 0; i < size_of(list); ++i) {
    const Json *name = member(element(list, i), "name"), *joints = member(element(list, i), "joints");
    skins.push_back({.name = name == nullptr ? std::string() : to_string(*name),
                     .joint_count = joints == nullptr ? 0 : size_of(*joints)});
  }
  return skins;
}

SkinReader::SkinReader(const Document& document, const AccessorTable& accessors, const std::vector<PlacedNode>& placed,
                       Notes& notes)
    : document_(document), accessors_(accessors), notes_(notes), placed_(by_node(placed)) {}

std::vector<const PlacedNode*> SkinReader::by_node(const std::vector<PlacedNode>& placed) const {
  std::vector<const PlacedNode*> places(document_.nodes.size(), nullptr);
  for (const PlacedNode& node : placed) {
    const PlacedNode*& place = places[static_cast<std::size_t>(&node.node - document_.nodes.data())];
    if (place == nullptr) place = &node;
  }
  return places;
}

const Skin& SkinReader::operator[](std::size_t skin) {
  const auto found = read_.find(skin);
  return found != read_.end() ? found->second : read_.emplace(skin, read(skin)).first->second;
}

Skin SkinReader::read(std::size_t index) {
  document_.wrong.check("skin", index);
  const JsonView view = view_of_skin(document_.json, index);
  Skin skin{.label = view.label(), .joints = {}};
  const Json* const joints = member(view.value, "joints");
  if (joints == nullptr || size_of(*joints) == 0) view.fail("has no 'joints'");
  joint_count_ += size_of(*joints);
  if (joint_count_ > kMaxJoints)
    view.refuse(fmt::format("with its joints the skins have more than {}; use fewer skins", kMaxJoints));
  const Accessor* matrices = nullptr;
  if (const Json* accessor = member(view.value, "inverseBindMatrices"))
    matrices = &check_matrices(view, accessors_[to_index(*accessor)], size_of(*joints));
  for (std::size_t i = 0; i < size_of(*joints); ++i) {
    glm::dmat4 joint = place_of(to_index(element(*joints, i)), skin.label);
    if (matrices != nullptr) {
      glm::dmat4 bind(matrices->matrix_at(i));
      if (!is_finite(bind)) view.fail(fmt::format("inverse bind matrix {} in {} is not finite", i, matrices->label));
      if (bind[0][3] != 0 || bind[1][3] != 0 || bind[2][3] != 0 || bind[3][3] != 1) {
        notes_.mended(
            fmt::format("{}: the last row of inverse bind matrix {} is not 0 0 0 1; taken as that", skin.label, i));
        for (int column = 0; column < 4; ++column) bind[column][3] = column == 3 ? 1 : 0;
      }
      joint = joint * bind;
    }
    if (!is_finite(joint)) view.refuse(fmt::format("the transform of its joint {} overflows; scale the scene down", i));
    skin.joints.push_back(joint);
  }
  return skin;
}

const glm::dmat4& SkinReader::place_of(std::size_t joint, const std::string& user) {
  if (placed_[joint] != nullptr) return placed_[joint]->world_from_object;
  if (!own_places_) {
    notes_.mended(fmt::format("{}: its joint {} is not in the scene; it stands where its own parents put it", user,
                              document_.nodes[joint].view.label()));
    own_places_.emplace(document_, notes_);
  }
  return (*own_places_)[joint];
}

}  // namespace eikon
