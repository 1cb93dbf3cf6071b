// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>

#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

inline constexpr const char* kShapeExtension = "EIKON_shape";
/// The document's list of shapes, by the draft of that name.
inline constexpr const char* kShapeListExtension = "KHR_implicit_shapes";

/// Whether a node of the checked document places a shape.
[[nodiscard]] bool has_shape(const Json& node);

/// Appends the shape that a node places: {"shape": {"type": "sphere", "sphere": {"radius": 0.5}}, "material": 0}, or with "shape"
/// an index into the document's KHR_implicit_shapes. A shape that its node scales to nothing is left out with a note.
/// use_material  as MeshReader's
/// throws InputError: no or an unknown type, a size that is not positive, finite and of 2^-60 to 2^40 m, a place beyond
///        kMaxCoordinate, an index out of range
void add_shape(const Json& document, const Place& node, const std::string& name, const glm::dmat4& world_from_object,
               const std::function<std::uint32_t(int)>& use_material, Scene& scene, Notes& notes);

/// Appends a shape of which all is known; one that its node scales to nothing is left out with a note.
/// throws InputError: a place beyond kMaxCoordinate
void place_shape(const Place& node, Shape shape, Scene& scene, Notes& notes);

}  // namespace eikon
