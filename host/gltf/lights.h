// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>
#include <string>

#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

/// Lights of KHR_lights_punctual, and the one that a node of the checked document places, by index; -1: none.
[[nodiscard]] std::int64_t light_of_node(const Json& node);

/// Appends light `index` of the document as a node places it: at its origin, along its -Z; the node's scale counts for
/// neither. Values outside their legal ranges are brought into them and named in `notes`; a light whose node leaves it no
/// direction, or a spot light without an opening, is left out with a note.
/// throws InputError: an intensity beyond single precision, a place beyond kMaxCoordinate
void add_light(const Json& document, std::size_t index, const Place& node, const std::string& node_name,
               const glm::dmat4& world_from_object, Scene& scene, Notes& notes);

}  // namespace eikon
