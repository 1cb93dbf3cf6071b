// SPDX-License-Identifier: Apache-2.0
// Surfaces by their equation: EIKON_shape.
#pragma once
#include "gltf/document/node_graph.h"
#include "gltf/materials/materials.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

inline constexpr const char* kShapeExtension = "EIKON_shape";
/// The extension with the document's list of shapes, after the Khronos draft of that name.
inline constexpr const char* kShapeListExtension = "KHR_implicit_shapes";

/// Appends the shape that a node of the checked document places, if it places one. A shape that its
/// node scales to nothing is left out with a note.
/// throws InputError: no or an unknown type, a size that is not positive, finite and of 2^-60 to
///        2^40 m, a position beyond kMaxCoordinate, an index out of range
void add_shape(const Json& document, const PlacedNode& placed, MaterialReader& materials, Scene& scene, Notes& notes);

/// Appends a shape of which all is known. One that its node scales to nothing is left out with a
/// note.
/// throws InputError: a position beyond kMaxCoordinate
void place_shape(const JsonView& node, Shape shape, Scene& scene, Notes& notes);

}  // namespace eikon
