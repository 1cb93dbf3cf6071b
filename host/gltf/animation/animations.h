// SPDX-License-Identifier: Apache-2.0
// The animations of a document. What they move is written into the document before anything else of
// it is read, so that the rest of the reader sees a file that stands still.
#pragma once
#include <string>

#include "gltf/document/accessor_table.h"
#include "gltf/document/wrong_parts.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// The document that animations are read from, and what the reader learns of them.
struct AnimationSource {
  Json& document;  // checked; no one holds references to what is inside its numbers and arrays of numbers
  const AccessorTable& accessors;
  WrongParts& wrong;  // gets animations that are damaged, unless `choice` names them
  Notes& notes;
};

/// Writes the values that the chosen animations have at the chosen time into the document, and
/// lists all animations in `scene`.
/// returns  a text that is the same whenever the pose is for the same reasons; empty if no
///          animation is in force
/// throws InputError: an animation that does not exist, or one that is damaged and asked for by its
/// name
std::string animate(const AnimationSource& source, const AnimationChoice& choice, Scene& scene);

}  // namespace eikon
