// SPDX-License-Identifier: Apache-2.0
// Vertices that follow the joints of a skin.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/geometry/morph.h"
#include "gltf/skin/skins.h"
#include "scene/notes.h"

namespace eikon {

/// True for the name of an attribute that skins change, or that says how: POSITION, NORMAL,
/// TANGENT, JOINTS_n, WEIGHTS_n.
[[nodiscard]] bool is_for_skins(const std::string& name);

/// Vertices as the joints have them.
struct SkinnedVertices {
  OwnAttributes own;           // POSITION, NORMAL and TANGENT in the world's coordinates, as floats
  std::vector<bool> mirrored;  // by vertex: its matrix mirrors; empty if that of no vertex does
};

/// Lets vertices follow their joints.
/// Each vertex has the weighted mean of its joints' matrices, normals the cofactors of that, turned
/// back where it mirrors, so that they still point to the front. Weights count by their shares of
/// their sum; weights that do not sum to 1 are named in `notes`, and so are negative ones and those
/// that are no numbers, which count as 0. A vertex without weights follows the first joint that it
/// names.
/// attributes  checked ones of a primitive with as many elements each, those of morph targets
///             included
/// throws InputError naming `user`: joints without weights, a joint with a weight that the skin
/// does not have
[[nodiscard]] SkinnedVertices skin_vertices(const Skin& skin, const std::map<std::string, const Accessor*>& attributes,
                                            const std::string& user, Notes& notes);

}  // namespace eikon
