// SPDX-License-Identifier: Apache-2.0
// Cameras of a file, with EIKON_camera_lens and EIKON_camera_panorama.
#pragma once
#include <string>

#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

inline constexpr const char* kLensExtension = "EIKON_camera_lens";
inline constexpr const char* kPanoramaExtension = "EIKON_camera_panorama";

/// Appends camera `index` of the checked document, placed by `node`, under its own name or else `node_name`. One whose node
/// scales its direction of view to nothing is left out with a note.
/// EIKON_camera_lens      of a perspective: {"radius": metres} or {"fNumber": N, "sensorHeight": metres}, "focusDistance": metres
/// EIKON_camera_panorama  {}: every direction around the camera; the rest of it is for readers that do not know the extension
/// throws InputError: an opening or a distance that is missing, not positive or beyond kMaxCoordinate
void add_camera(const Json& document, std::size_t index, const glm::dmat4& world_from_node, const Place& node,
                const std::string& node_name, Scene& scene, Notes& notes);

}  // namespace eikon
