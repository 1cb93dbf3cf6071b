// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "scene/document.h"
#include "scene/text.h"

namespace eikon {

/// Material `index` of the document with its values inside their legal ranges; what was outside is named in `notes`.
/// throws InputError for a value that single precision cannot hold
Material convert_material(const tinygltf::Model& model, const Json& document, std::size_t index, Notes& notes);

/// Names what this version leaves out of a material that is used.
void note_unsupported(const tinygltf::Model& model, const Json& document, std::size_t index, const Material& material,
                      Notes& notes);

/// glTF's material of a primitive that has none: white, metallic and rough [glTF 2.0, section 3.9].
Material default_material(Notes& notes);

}  // namespace eikon
