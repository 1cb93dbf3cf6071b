// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>

#include "io/json_text.h"
#include "io/xxhash64.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// Reads extras.environment of a scene or document: {"radiance": [r, g, b]}, or {"uri": "sky.exr",
/// "scale": 1, "rotate": 0} with a file in `folder` and degrees about +Y. Returns nothing if it is
/// absent. The file is added to `digest`.
/// throws InputError: as load_environment; negative radiance or scale; a URI that leads out of
///        `folder`
std::optional<Environment> read_environment(const JsonView& owner, const std::filesystem::path& folder, Digest& digest,
                                            Notes& notes);

}  // namespace eikon
