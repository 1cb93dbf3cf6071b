// SPDX-License-Identifier: Apache-2.0
// Light from infinitely far away: maps in files, and what a scene says of them.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/digest.h"
#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

/// Reads an equirectangular map from OpenEXR (channels R, G, B, or Y for grey) or Radiance HDR, told apart by their first
/// bytes. Colours are taken as linear Rec. 709. Texels that are negative or not finite become black, and are counted in
/// a line of `warnings`; so is a map that is black altogether, which is legal and gives no light.
/// throws InputError with the file: missing, another format, too large for a quarter of the memory, truncated, damaged
std::shared_ptr<const EnvironmentMap> load_environment(const std::filesystem::path& path,
                                                       std::vector<std::string>& warnings);

/// extras.environment of a scene or document: {"radiance": [r, g, b]}, or {"uri": "sky.exr", "scale": 1, "rotate": 0}
/// with a file in `folder` and degrees about +Y. Nothing where it is absent. The file is added to `digest`.
/// throws InputError: as load_environment; negative radiance or scale; a URI that leads out of `folder`
std::optional<Environment> read_environment(const Place& owner, const std::filesystem::path& folder, Digest& digest,
                                            Notes& notes);

}  // namespace eikon
