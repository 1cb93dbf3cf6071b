// SPDX-License-Identifier: Apache-2.0
// Point, spot and directional lights: KHR_lights_punctual.
#pragma once
#include "gltf/document/node_graph.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// Checks the members of a light of KHR_lights_punctual. throws InputError naming what is wrong
void check_light(const JsonView& light);

/// Appends the light that a node places, if it places one: at the node's origin, along its -Z; its
/// scale counts for neither. Values outside their legal ranges are brought into them and named in
/// `notes`. A light whose node leaves it no direction, or a spot light without an opening, is left
/// out with a note.
/// throws InputError: an intensity beyond single precision, a position beyond kMaxCoordinate
void add_light(const Json& document, const PlacedNode& placed, Scene& scene, Notes& notes);

}  // namespace eikon
