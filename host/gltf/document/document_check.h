// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "gltf/document/wrong_parts.h"
#include "io/json_text.h"

namespace eikon {

/// Checks the shape of a glTF document that every later step relies on: version, required
/// extensions, the type of every member that is read, and every index between nodes, meshes,
/// materials, textures, cameras, skins, animations, accessors, bufferViews and scenes.
/// AccessorTable checks what is in the buffers, and walk_nodes the graph of nodes.
///
/// A node, mesh, material, accessor or animation that is wrong is added to `wrong`, and an empty
/// object takes its place in the document. Everything else that is wrong throws InputError with the
/// place.
void check_document(Json& document, WrongParts& wrong);

/// The array `key` of the document, or an empty one if it is absent.
[[nodiscard]] const Json& items(const Json& document, const char* key);
/// The number of its elements.
[[nodiscard]] std::size_t count_of(const Json& document, const char* key);

/// Checks the types and the index of the texture in slot `key` of a material or of a part of one,
/// if there is any.
void check_texture_slot(const JsonView& owner, const char* key, std::size_t texture_count);

}  // namespace eikon
