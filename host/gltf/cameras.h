// SPDX-License-Identifier: Apache-2.0
// Cameras of a file, with EIKON_camera_lens and EIKON_camera_panorama.
#pragma once
#include "gltf/document/node_graph.h"
#include "io/json_text.h"
#include "scene/scene.h"
#include "scene/notes.h"

namespace eikon {

inline constexpr const char* kLensExtension = "EIKON_camera_lens";
inline constexpr const char* kPanoramaExtension = "EIKON_camera_panorama";

/// Appends the camera of a node that has one, under its own name or else the node's. A camera whose
/// node scales its direction of view to nothing is left out with a note.
/// throws InputError: an opening or a distance that is missing, not positive or beyond
///        kMaxCoordinate, a position beyond it, as orthographic_aspect
void add_camera(const Json& document, const PlacedNode& placed, Scene& scene, Notes& notes);

/// Width over height of an orthographic camera's picture; `lens` has numbers other than 0 as xmag
/// and ymag. throws InputError for a picture that is a line
double orthographic_aspect(const JsonView& lens);

}  // namespace eikon
