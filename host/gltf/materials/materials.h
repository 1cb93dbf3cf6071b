// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"
#include "gltf/materials/textures.h"

namespace eikon {

/// Material `index` of the checked document without its textures. Values outside their legal ranges are brought into them
/// and named in `notes`. throws InputError for a value that single precision cannot hold
Material convert_material(const Json& document, std::size_t index, Notes& notes);

/// Adds the textures of a material that is used, but for those whose factor is 0, and names in `notes` what of the material
/// is left out. throws InputError as TextureReader::find
void complete_material(const Json& document, std::size_t index, TextureReader& textures, Material& material,
                       Notes& notes);

}  // namespace eikon
