// SPDX-License-Identifier: Apache-2.0
// Environments that are pictures of the six faces of a cube.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace eikon {

/// How the faces lie in a picture. In a cross the middle of the four in a row or column is ahead
/// (-Z), with its neighbours around it as one sees them from inside. Strips have the faces right,
/// left, up, down, ahead, behind in the orientation of OpenGL's and Vulkan's cube maps, except the
/// one of OpenEXR's attribute `envmap` [ImfEnvmap.h].
enum class CubeLayout { horizontal_cross, vertical_cross, row, column, openexr };

/// The layout of a picture, or nothing for one that is no cube map. By its sides: 4 : 3 and 3 : 4
/// are crosses if what lies beside the cross is all of one colour, 6 : 1 and 1 : 6 are strips.
/// is_openexr  the file says that it is a cube map
[[nodiscard]] std::optional<CubeLayout> cube_layout(std::uint32_t width, std::uint32_t height,
                                                    const std::vector<glm::vec3>& rgb, bool is_openexr);

/// "horizontal cross", ...
[[nodiscard]] const char* name_of(CubeLayout layout);

/// Pixels along a side of a face.
[[nodiscard]] std::uint32_t face_side(CubeLayout layout, std::uint32_t width);

/// The equirectangular map of 4 x 2 faces' sides (see EnvironmentMap) of a cube map, row by row
/// from the top.
/// width  of the picture
[[nodiscard]] std::vector<glm::vec3> equirectangular(CubeLayout layout, std::uint32_t width,
                                                     const std::vector<glm::vec3>& cube);

}  // namespace eikon
