// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/json_text.h"

namespace eikon {

/// Checks the shape of a glTF document that every later step relies on: version, required extensions, the type of every
/// member that is read, and every index between nodes, meshes, materials, textures, cameras, skins, animations,
/// accessors, bufferViews and scenes. What is in the buffers is checked by AccessorTable, the graph of nodes by
/// walk_nodes. throws InputError with the place
void check_document(const Json& document);

/// The array `key` of the document; an empty one if it is absent.
[[nodiscard]] const Json& items(const Json& document, const char* key);

/// A texture in slot `key` of a material or a part of one, if there is any: its types and its index.
void check_texture_slot(const Place& owner, const char* key, std::size_t texture_count);

}  // namespace eikon
