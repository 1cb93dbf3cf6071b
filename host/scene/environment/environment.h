// SPDX-License-Identifier: Apache-2.0
// Environment maps: pictures of light from infinitely far away.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace eikon {

inline constexpr std::uint64_t kMaxEnvironmentFileBytes = std::uint64_t{1} << 34U;

/// Reads an equirectangular map from OpenEXR (channels R, G, B, or Y for grey) or Radiance HDR,
/// told apart by their first bytes. Colours are taken as linear Rec. 709, unless the file states
/// other primaries or is XYZE, and a cube map becomes an equirectangular one (cube_map.h); both are
/// said in `warnings`. Texels that are negative or not finite become black and are counted in a
/// line of `warnings`. A map that is black altogether is legal and gives no light, and has a line
/// in `warnings` too.
/// throws InputError with the file: missing, another format, too large for a quarter of the memory,
///        truncated, damaged
std::shared_ptr<const EnvironmentMap> load_environment(const std::filesystem::path& path,
                                                       std::vector<std::string>& warnings);

}  // namespace eikon
